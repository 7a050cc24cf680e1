#include "server/pipeline/scene_history.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <system_error>

#include "common/base/log.h"
#include "common/image/image_file.h"
#include "server/pipeline/proposal_json.h"
#include "server/pipeline/result_json.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return {};
  return fail(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
}

Status write_bytes(const fs::path& file, const std::vector<std::byte>& bytes) {
  std::ofstream out{file, std::ios::binary};
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out) return {};
  return fail(fmt::format("cannot write '{}'; is the disk full, or the folder not yours?", file.string()));
}

/// The names of the files; damaged pictures are left out, and counted.
Result<std::vector<std::string>> write_pictures(const RevisionInfo& info, const fs::path& folder, int& damaged) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < info.pictures.size(); ++i) {
    auto name = fmt::format("revision_{:04}_{}.png", info.revision, i + 1);
    if (const auto whole = decode_png(info.pictures[i]); !whole) {
      log_warning("picture {} of revision {} is damaged and not written: {}", i + 1, info.revision,
                  whole.error().message);
      ++damaged;
      continue;
    }
    if (auto done = write_bytes(folder / name, info.pictures[i]); !done) return fail(done.error());
    names.push_back(std::move(name));
  }
  return names;
}

std::string revision_text(const RevisionInfo& info) {
  return fmt::format("{:>5}  {}  +{} -{} triangles  {}: {}\n", info.revision, time_text(info.accepted_ns),
                     info.triangles_added, info.triangles_removed, info.author, info.summary);
}

std::string record_text(const ProposalRecord& record) {
  auto text = proposal_line(record) + '\n';
  if (!record.author.empty()) text += fmt::format("{:7}{}\n", "", decision_text(record));
  text += fmt::format("{:7}first seen {}, last seen {}\n", "", time_text(record.first_seen_ns),
                      time_text(record.last_seen_ns));
  return text;
}

}  // namespace

Result<bool> would_empty(const SceneStore& store, bool back) {
  if (store.model()->triangle_count() == 0) return false;
  const auto shown = back ? store.shown_by_undo() : store.shown_by_redo();
  if (!shown) return fail(shown.error());
  if (!*shown) return false;
  const auto model = store.model_at(**shown);
  if (!model) return fail(model.error());
  return (*model)->triangle_count() == 0;
}

Status print_log(const SceneStore& store, bool json, const std::string& pictures_folder) {
  const auto log = store.log();
  if (!log) return fail(log.error());
  if (!pictures_folder.empty()) {
    if (auto made = make_folder(pictures_folder); !made) return made;
  }
  nlohmann::json revisions = nlohmann::json::array();
  nlohmann::json calibrations = nlohmann::json::object();
  int damaged = 0;
  for (const auto& info : *log) {
    std::vector<std::string> files;
    if (!pictures_folder.empty()) {
      auto written = write_pictures(info, pictures_folder, damaged);
      if (!written) return fail(written.error());
      files = std::move(*written);
    }
    if (!json) {
      std::cout << revision_text(info);
      for (const auto& file : files) std::cout << fmt::format("{:7}{}\n", "", file);
      continue;
    }
    revisions.push_back(revision_json(info));
    if (!pictures_folder.empty()) revisions.back()["picture_files"] = files;
    if (info.snapshot) calibrations[calibration_name(info.snapshot->calibration)] = info.snapshot->calibration;
  }
  if (json) print_json({{"revisions", revisions}, {"calibrations", calibrations}});
  if (damaged == 0) return {};
  return fail(fmt::format("{} damaged picture{} not written", damaged, damaged == 1 ? " was" : "s were"));
}

Status print_proposals(const SceneStore& store, bool json, std::optional<ProposalState> state) {
  const auto records = store.proposals();
  if (!records) return fail(records.error());
  nlohmann::json list = nlohmann::json::array();
  for (const auto& record : *records) {
    if (state && record.state != *state) continue;
    list.push_back(proposal_json(record));
    if (!json) std::cout << record_text(record);
  }
  if (json) {
    print_json({{"proposals", list}});
  } else if (list.empty()) {
    std::cout << "no proposals; `adjust` and `run` make them\n";
  }
  return {};
}

}  // namespace meshloop
