// `detect`: a recording against a model, in batch.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "common/image/image_file.h"
#include "common/program/arguments.h"
#include "common/program/model_arguments.h"
#include "server/evaluate/label_score.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/examiner.h"
#include "server/pipeline/options.h"
#include "server/pipeline/result_json.h"
#include "server/show/overlay.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

struct DetectArguments {
  ModelArguments model;
  RecordingArguments recording;
  std::string frames;
  std::string threshold = "3sigma";
  std::string out;
  std::string truth;
  std::string palette = "paper";
  bool json = false;
};

struct DetectRun {
  DetectArguments arguments;
  Threshold threshold;
  std::vector<int> frames;  // empty: all
  std::optional<LabelScore> score;
  nlohmann::json results = nlohmann::json::array();
  std::vector<double> total_ms;
};

std::string numbered(const char* name, int frame, const char* ending) {
  return fmt::format("{}_{:06}.{}", name, frame, ending);
}

GreyImage label_numbers(const Image<Label>& labels) {
  GreyImage numbers{labels.width(), labels.height()};
  std::transform(labels.pixels().begin(), labels.pixels().end(), numbers.pixels().begin(),
                 [](Label label) { return static_cast<std::uint8_t>(label); });
  return numbers;
}

Status write_pictures(const DetectRun& run, const TrackedFrame& tracked, const Examination& examination,
                      const Rig& rig) {
  const fs::path out = run.arguments.out;
  const int index = tracked.frame.index;
  OverlayOptions options;
  options.palette = run.arguments.palette == "safe" ? Palette::color_blind_safe : Palette::paper;
  options.title = fmt::format("frame {}, threshold {}", index, run.arguments.threshold);
  const auto& comparison = examination.comparison;
  const auto on_color =
      overlay_on_color(comparison, tracked.frame.depth, tracked.frame.color, rig, &examination.regions, options);
  const auto on_depth = overlay_on_depth(comparison, tracked.frame.depth, options);
  for (const Status& done : {write_tiff(out / numbered("difference", index, "tiff"), comparison.difference_m),
                             write_png(out / numbered("labels", index, "png"), label_numbers(comparison.labels)),
                             write_png(out / numbered("overlay", index, "png"), on_color),
                             write_png(out / numbered("overlay_depth", index, "png"), on_depth)}) {
    if (!done) return done;
  }
  return {};
}

Result<DepthTruth> read_truth(const fs::path& folder, int frame) {
  auto measured = read_tiff(folder / numbered("measured", frame, "tiff"));
  if (!measured) return fail("ground truth", measured.error());
  const fs::path previous = folder / numbered("previous", frame, "tiff");
  auto expected = read_tiff(fs::exists(previous) ? previous : folder / numbered("expected", frame, "tiff"));
  if (!expected) return fail("ground truth", expected.error());
  return DepthTruth{std::move(*measured), std::move(*expected)};
}

Status score_frame(DetectRun& run, const TrackedFrame& tracked, const Examination& examination) {
  if (!run.score) return {};
  const auto truth = read_truth(run.arguments.truth, tracked.frame.index);
  if (!truth) return fail(truth.error());
  const auto& labels = examination.comparison.labels;
  for (const auto* image : {&truth->measured, &truth->expected}) {
    if (image->width() != labels.width() || image->height() != labels.height()) {
      return fail(
          fmt::format("the ground truth of frame {} has another size than the depth image", tracked.frame.index));
    }
  }
  run.score->add(examination.comparison, examination.regions, *truth);
  return {};
}

Status detect_frame(DetectRun& run, const TrackedFrame& tracked, const Model& model, const Rig& rig,
                    Examiner& examiner) {
  nlohmann::json result{{"index", tracked.frame.index}, {"timestamp", tracked.frame.depth_timestamp_s}};
  if (tracked.depth_pose.state == TrackState::lost) {
    result["state"] = "lost";
    run.results.push_back(std::move(result));
    return {};
  }
  auto examination = examiner.examine(tracked, model);
  if (!examination) return fail(fmt::format("frame {}", tracked.frame.index), examination.error());
  if (auto done = score_frame(run, tracked, *examination); !done) return done;
  if (auto done = write_pictures(run, tracked, *examination, rig); !done) return done;
  run.total_ms.push_back(examination->total_ms);
  result["state"] = name_of(tracked.depth_pose.state);
  result["counts"] = counts_json(examination->comparison);
  result["time_ms"] = times_json(*examination);
  result["regions"] = nlohmann::json::array();
  for (const auto& region : examination->regions.regions) result["regions"].push_back(region_json(region));
  run.results.push_back(std::move(result));
  return {};
}

nlohmann::json score_json(const LabelScore& score) {
  nlohmann::json iou;
  nlohmann::json pixels;
  for (const Label label : {Label::closer, Label::farther, Label::unmodelled}) {
    const std::string name{info(label).name};
    const auto& counts = score.counts(label);
    iou[name] = score.iou(label);
    pixels[name] = {{"both", counts.both}, {"either", counts.either}, {"truth", counts.in_truth}};
  }
  const auto& counts = score.counts();
  pixels["change"] = {{"changed", counts.changed},
                      {"undecided", counts.changed_undecided},
                      {"above_threshold", counts.above_threshold},
                      {"found", counts.found},
                      {"unchanged", counts.unchanged},
                      {"falsely_changed", counts.falsely_changed}};
  return {{"iou", iou},
          {"recall", score.recall()},
          {"false_change", score.false_change()},
          {"undecided", score.undecided()},
          {"pixels", pixels}};
}

// "12 closer, 0 farther, 7 unmodelled"
std::string changes_text(const nlohmann::json& counts) {
  std::vector<std::string> parts;
  for (const auto& label : kLabels) {
    if (!is_change(label.label)) continue;
    parts.push_back(fmt::format("{} {}", counts[std::string{label.name}].get<std::size_t>(), label.name));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void report(const DetectRun& run, const ImportedModel& model) {
  nlohmann::json json{{"frames", run.results}, {"time_ms", spread_json(run.total_ms)}, {"model", import_json(model)}};
  if (run.score) json["truth"] = score_json(*run.score);
  if (run.arguments.json) {
    print_json(json);
    return;
  }
  std::cout << import_text(run.arguments.model.file, model) << '\n';
  for (const auto& frame : run.results) {
    if (!frame.contains("counts")) {
      std::cout << fmt::format("frame {}: the pose is lost\n", frame["index"].get<int>());
      continue;
    }
    std::cout << fmt::format("frame {}: {} pixels in {} regions\n", frame["index"].get<int>(),
                             changes_text(frame["counts"]), frame["regions"].size());
  }
  std::cout << "pictures and differences are in " << run.arguments.out << '\n';
}

Status check_frames(const DetectRun& run, int frames_read) {
  if (!run.frames.empty() && run.frames.back() >= frames_read) {
    return fail(fmt::format("frame {} is not in the recording, which has {} frames", run.frames.back(), frames_read),
                ErrorKind::usage);
  }
  return {};
}

Status process(DetectRun& run, const Model& model, TrackedFrames& frames, Examiner& examiner) {
  int read = 0;
  for (;;) {
    auto tracked = frames.next();
    if (!tracked) return fail(tracked.error());
    if (!*tracked) return check_frames(run, read);
    read = (*tracked)->frame.index + 1;
    const bool wanted = run.frames.empty() || std::binary_search(run.frames.begin(), run.frames.end(), read - 1);
    if (wanted) {
      if (auto done = detect_frame(run, **tracked, model, frames.rig(), examiner); !done) return done;
    }
    if (!run.frames.empty() && read > run.frames.back()) return {};
  }
}

Status detect(const DetectArguments& arguments) {
  DetectRun run;
  run.arguments = arguments;
  const auto threshold = parse_threshold(arguments.threshold);
  if (!threshold) return fail(threshold.error());
  if (!arguments.frames.empty()) {
    auto list = parse_frame_list(arguments.frames);
    if (!list) return fail(list.error());
    run.frames = std::move(*list);
  }
  const auto imported = arguments.model.import();
  if (!imported) return fail(imported.error());
  auto frames = arguments.recording.open();
  if (!frames) return fail(frames.error());
  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (error) return fail(fmt::format("cannot make the folder '{}': {}", arguments.out, error.message()));
  if (!arguments.truth.empty()) run.score.emplace(frames->rig().sensor, 3.0);
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto examiner = Examiner::create(**gpu, frames->rig(), ExaminerOptions::of(*threshold));
  if (!examiner) return fail(examiner.error());
  if (auto done = process(run, imported->model, *frames, *examiner); !done) return done;
  report(run, *imported);
  return {};
}

}  // namespace

void add_detect_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<DetectArguments>();
  CLI::App* command = app.add_subcommand("detect", "compare a recording with a model, in batch");
  arguments->model.add_to(*command, "--model");
  arguments->recording.add_to(*command, true);
  command->add_option("--frames", arguments->frames, "frames to compare, from 0, such as 0,5,10-20; all if not given");
  command->add_option("--threshold", arguments->threshold, kThresholdHelp)->capture_default_str();
  command->add_option("--out", arguments->out, "folder for differences, labels and overlays")->required();
  command->add_option("--truth", arguments->truth, "folder of exact depth images (made by simulate): adds a score");
  command->add_option("--palette", arguments->palette, "colours of the overlays")
      ->check(CLI::IsMember({"paper", "safe"}))
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "results as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return detect(*arguments); }; });
}

}  // namespace meshloop
