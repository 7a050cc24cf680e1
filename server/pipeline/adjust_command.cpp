// `adjust`: snapshots to new revisions, in batch.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "common/base/clock.h"
#include "common/program/arguments.h"
#include "common/recording/recording.h"
#include "server/pipeline/adjuster.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/options.h"
#include "server/pipeline/recent_depths.h"
#include "server/pipeline/result_json.h"
#include "server/pipeline/views.h"

namespace meshloop {
namespace {

struct AdjustArguments {
  std::string scene;
  RecordingArguments recording;
  std::string frames;
  ThresholdArguments threshold;
  std::string accept;
  OperatorArguments person;
  SurfaceArguments surface;
  ViewArguments views;
  bool json = false;
};

struct AdjustRun {
  std::vector<int> frames;
  bool accept_all = false;
  std::vector<int> accepted_ids;
  /// For the journal.
  std::string author;
  std::string calibration;
  AdjustOptions options;
  /// Frames that may be fused with a listed one.
  RecentDepths recent{1};
  std::optional<TrackedPose> previous_pose;
  nlohmann::json results = nlohmann::json::array();
};

Result<AdjustRun> make_run(const AdjustArguments& arguments) {
  AdjustRun run;
  auto frames = parse_frame_list(arguments.frames);
  if (!frames) return fail(frames.error());
  run.frames = std::move(*frames);
  run.options = arguments.surface.adjust_options();
  run.recent = RecentDepths{static_cast<std::size_t>(arguments.surface.fuse)};
  run.accept_all = arguments.accept == "all";
  if (!run.accept_all && !arguments.accept.empty()) {
    auto ids = parse_frame_list(arguments.accept);
    if (!ids) {
      return fail(fmt::format("--accept takes all, or ids such as 1,3, not '{}'", arguments.accept), ErrorKind::usage);
    }
    run.accepted_ids = std::move(*ids);
    if (run.frames.size() != 1) return fail("--accept with ids needs a single frame in --frames", ErrorKind::usage);
  }
  return run;
}

std::vector<Proposal> chosen(const AdjustRun& run, const std::vector<Proposal>& proposals) {
  std::vector<Proposal> accepted;
  std::copy_if(proposals.begin(), proposals.end(), std::back_inserter(accepted), [&](const Proposal& proposal) {
    return run.accept_all ||
           std::binary_search(run.accepted_ids.begin(), run.accepted_ids.end(), static_cast<int>(proposal.id));
  });
  return accepted;
}

/// Says which of the ids that --accept names are not proposed.
Status check_chosen(const AdjustRun& run, int frame, const std::vector<Proposal>& proposals) {
  std::vector<int> there;
  for (const auto& proposal : proposals) there.push_back(static_cast<int>(proposal.id));
  for (const int id : run.accepted_ids) {
    if (std::find(there.begin(), there.end(), id) != there.end()) continue;
    return fail(there.empty()
                    ? fmt::format("frame {} has no proposal {}: it proposes nothing", frame, id)
                    : fmt::format("frame {} has no proposal {}; it has {}", frame, id, fmt::join(there, ", ")));
  }
  return {};
}

nlohmann::json proposal_json(const Proposal& proposal) {
  nlohmann::json json{{"id", proposal.id},
                      {"kind", proposal.kind == ChangeKind::insertion ? "insertion" : "removal"},
                      {"triangles_added", proposal.triangles_added},
                      {"triangles_removed", proposal.triangles_removed},
                      {"largest_change_m", proposal.largest_change_m},
                      {"effect", proposal.effect}};
  if (!proposal.move) return json;
  json["kind"] = "move";
  json["move"] = move_json(*proposal.move);
  return json;
}

Status adjust_frame(AdjustRun& run, const TrackedFrame& tracked, const Rig& rig, Examiner& examiner, Views& views,
                    SceneStore& store) {
  nlohmann::json result{{"index", tracked.frame.index}, {"revision", nullptr}, {"proposals", nlohmann::json::array()}};
  if (const auto reason = reason_against(tracked.depth_pose)) {
    if (!run.accepted_ids.empty()) return fail(fmt::format("frame {}: {}", tracked.frame.index, *reason));
    result["reason"] = *reason;
    run.results.push_back(std::move(result));
    return {};
  }
  examiner.model_changed();  // each listed frame stands for itself
  auto examination = examiner.examine(tracked, *store.model());
  if (!examination) return fail(fmt::format("frame {}", tracked.frame.index), examination.error());
  const Stopwatch watch;
  const auto [proposals, registration, fused] =
      propose_changes(tracked, *examination, run.recent.before(tracked, 0), rig, store, run.options);
  result["frames_fused"] = fused;
  result["time_ms"] = {{"snapshot", watch.milliseconds()}};
  result["registration"] = registration_json(registration, tracked.depth_pose);
  for (const auto& proposal : proposals) result["proposals"].push_back(proposal_json(proposal));
  if (auto ok = check_chosen(run, tracked.frame.index, proposals); !ok) return ok;
  const auto accepted = chosen(run, proposals);
  if (!accepted.empty()) {
    const auto frame = fmt::format("frame {}", tracked.frame.index);
    auto picture = views.on_color(tracked, *examination, frame);
    if (!picture) return fail(frame, picture.error());
    const Evidence evidence{run.author, snapshot_info(tracked, registration, run.calibration), std::move(*picture)};
    const auto acceptance = accept_changes(store, accepted, evidence);
    if (!acceptance) return fail(frame, acceptance.error());
    if (auto synced = store.sync(); !synced) {
      return fail(fmt::format("{}: revision {} may be gone at the next start", frame, acceptance->info.revision),
                  synced.error());
    }
    result["revision"] = acceptance->info.revision;
    result["triangles_added"] = acceptance->info.triangles_added;
    result["triangles_removed"] = acceptance->info.triangles_removed;
  }
  run.results.push_back(std::move(result));
  return {};
}

/// `done`: how the run ended; the frames before an error are told too, for their revisions stay.
void report(const AdjustArguments& arguments, const AdjustRun& run, const Model& model, const Status& done) {
  if (arguments.json) {
    nlohmann::json json{{"frames", run.results}, {"revision", model.revision}, {"triangles", model.triangle_count()}};
    if (!done) json["error"] = done.error().message;
    print_json(json);
    return;
  }
  for (const auto& frame : run.results) {
    std::cout << fmt::format("frame {}: ", frame["index"].get<int>());
    if (frame.contains("reason")) {
      std::cout << frame["reason"].get<std::string>() << '\n';
      continue;
    }
    const auto& proposals = frame["proposals"];
    std::cout << (frame["revision"].is_null() ? "nothing accepted"
                                              : fmt::format("revision {}", frame["revision"].get<int>()))
              << fmt::format(", {} proposals\n", proposals.size());
    for (const auto& proposal : proposals) {
      std::cout << fmt::format("  {:>3}: {}\n", proposal["id"].get<int>(), proposal["effect"].get<std::string>());
    }
  }
}

Status adjust_all(AdjustRun& run, TrackedFrames& frames, Examiner& examiner, Views& views, SceneStore& store) {
  int read = 0;
  while (read <= run.frames.back()) {
    auto tracked = frames.next();
    if (!tracked) return fail(tracked.error());
    if (!*tracked) break;
    read = (*tracked)->frame.index + 1;
    const bool is_sharp = !reason_to_wait(**tracked, run.previous_pose);
    run.previous_pose = (*tracked)->depth_pose;
    if (is_sharp) run.recent.add(**tracked);
    if (!std::binary_search(run.frames.begin(), run.frames.end(), read - 1)) continue;
    if (auto done = adjust_frame(run, **tracked, frames.rig(), examiner, views, store); !done) return done;
  }
  return {};
}

Status adjust(const AdjustArguments& arguments) {
  auto run = make_run(arguments);
  if (!run) return fail(run.error());
  auto options = arguments.threshold.examiner_options();
  if (!options) return fail(options.error());
  options->wait_for_detail = true;
  auto store = SceneStore::open(arguments.scene, false);
  if (!store) return fail(store.error());
  auto frames = arguments.recording.open();
  if (!frames) return fail(frames.error());
  if (auto there = frames->check_frames(run->frames); !there) return there;
  run->author = arguments.person.name;
  run->calibration = rig_text(frames->calibration());
  options->regions.confirm_views = 1;
  auto examiner = Examiner::create(frames->rig(), *options);
  if (!examiner) return fail(examiner.error());
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto views = Views::create(**gpu, frames->rig(), arguments.views);
  if (!views) return fail(views.error());
  auto done = adjust_all(*run, *frames, *examiner, *views, **store);
  const auto is_lost = [](const nlohmann::json& frame) { return frame.contains("reason"); };
  if (done && std::all_of(run->results.begin(), run->results.end(), is_lost)) done = fail(kEveryFrameIsLost);
  if (!run->results.empty()) report(arguments, *run, *(*store)->model(), done);
  return done;
}

}  // namespace

void add_adjust_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<AdjustArguments>();
  CLI::App* command = app.add_subcommand("adjust", "adapt the model to snapshots of a recording, in batch");
  command->add_option("--scene", arguments->scene, "the scene file")->required();
  arguments->recording.add_to(*command, true);
  command->add_option("--frames", arguments->frames, "frames to take as snapshots, from 0, such as 0,5,10-20")
      ->required();
  arguments->threshold.add_to(*command);
  command->add_option("--accept", arguments->accept,
                      "all, or ids of proposals (1,3), each of which counts once; nothing is accepted if not given");
  arguments->surface.add_to(*command);
  arguments->person.add_to(*command);
  arguments->views.add_colors_to(*command);
  command->add_flag("--json", arguments->json, "proposals and revisions as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return adjust(*arguments); }; });
}

}  // namespace meshloop
