// `detect`: a recording against a model, in batch.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>

#include "common/image/image_file.h"
#include "common/program/arguments.h"
#include "common/program/model_arguments.h"
#include "server/evaluate/label_score.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/detect_files.h"
#include "server/pipeline/examiner.h"
#include "server/pipeline/options.h"
#include "server/pipeline/region_pictures.h"
#include "server/pipeline/result_json.h"
#include "server/pipeline/views.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

struct DetectArguments {
  ModelArguments model;
  RecordingArguments recording;
  std::string frames;
  ThresholdArguments threshold;
  int average = 1;
  std::string out;
  std::string truth;
  ViewArguments views;
  bool json = false;
};

struct DetectRun {
  DetectArguments arguments;
  std::vector<int> frames;  // empty: all
  RegionPictures pictures;
  /// With --average: the frames that are collected, and the first of them.
  std::optional<FrameAverage> average;
  std::optional<TrackedFrame> first_of_average;
  std::optional<LabelScore> score;
  nlohmann::json results = nlohmann::json::array();
  std::vector<double> total_ms;
  /// Of an earlier run; nothing until the first frame is there to take their place.
  std::optional<std::size_t> removed_files;
};

// remove_files_of_detect knows these names.
std::string numbered(const char* name, int frame, const char* ending) {
  return fmt::format("{}_{:06}.{}", name, frame, ending);
}

GreyImage label_numbers(const Image<Label>& labels) {
  GreyImage numbers{labels.width(), labels.height()};
  std::transform(labels.pixels().begin(), labels.pixels().end(), numbers.pixels().begin(),
                 [](Label label) { return static_cast<std::uint8_t>(label); });
  return numbers;
}

Status write_images(const DetectRun& run, int index, const Comparison& comparison) {
  const fs::path out = run.arguments.out;
  auto done = write_tiff(out / numbered("difference", index, "tiff"), comparison.difference_m);
  return done ? write_png(out / numbered("labels", index, "png"), label_numbers(comparison.labels)) : done;
}

Status write_views(const DetectRun& run, const TrackedFrame& tracked, const Examination& examination, Views& views) {
  const fs::path out = run.arguments.out;
  const int index = tracked.frame.index;
  const auto title = fmt::format("frame {}, threshold {}, {}", index, run.arguments.threshold.text(),
                                 smallest_change_text(examination));
  if (views.wants_color()) {
    const auto picture = views.on_color(tracked, examination, title);
    if (!picture) return fail(picture.error());
    if (auto done = write_png(out / numbered("overlay", index, "png"), *picture); !done) return done;
  }
  if (!views.wants_depth()) return {};
  return write_png(out / numbered("overlay_depth", index, "png"), views.on_depth(tracked, examination, title));
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

/// A frame that is being compared while the next one is read. Stays where it is meanwhile.
struct InFlight {
  TrackedFrame tracked;
  std::optional<AveragedDepth> average;
  /// Reads the others, and therefore ends before them.
  std::optional<Examiner::Begun> begun;
};

/// What frames are compared with, and how their pictures are drawn.
struct Stages {
  const Model& model;
  Examiner& examiner;
  Views& views;
  std::unique_ptr<InFlight> in_flight = nullptr;
};

void begin_frame(DetectRun& run, TrackedFrame tracked, std::optional<AveragedDepth> average, Stages& stages) {
  if (tracked.depth_pose.state == TrackState::lost) {
    run.results.push_back(
        {{"index", tracked.frame.index}, {"timestamp", tracked.frame.depth_timestamp_s}, {"state", "lost"}});
    return;
  }
  stages.in_flight = std::unique_ptr<InFlight>{new InFlight{std::move(tracked), std::move(average), std::nullopt}};
  InFlight& frame = *stages.in_flight;
  frame.begun.emplace(stages.examiner.begin(frame.tracked, stages.model, frame.average ? &*frame.average : nullptr));
}

nlohmann::json frame_json(const DetectRun& run, const InFlight& frame, const Examination& examination) {
  const TrackedFrame& tracked = frame.tracked;
  nlohmann::json result{{"index", tracked.frame.index}, {"timestamp", tracked.frame.depth_timestamp_s}};
  result["state"] = name_of(tracked.depth_pose.state);
  if (frame.average) result["averaged_frames"] = frame.average->count;
  result["smallest_change_m"] = smallest_change_json(examination);
  if (!examination.smallest_change_m) result["why_nothing"] = why_nothing_can_be_told(examination);
  result["counts"] = counts_json(examination.comparison);
  result["time_ms"] = times_json(examination);
  result["regions"] = nlohmann::json::array();
  for (const auto& region : examination.regions.regions) {
    result["regions"].push_back(region_json(region));
    if (const auto file = run.pictures.file_of(region.id); !file.empty()) result["regions"].back()["picture"] = file;
  }
  return result;
}

/// The rest of the frame in flight, if there is one.
Status finish_frame(DetectRun& run, Stages& stages) {
  if (!stages.in_flight) return {};
  const auto frame = std::move(stages.in_flight);
  const TrackedFrame& tracked = frame->tracked;
  auto examination = stages.examiner.finish(std::move(*frame->begun));
  if (!examination) return fail(fmt::format("frame {}", tracked.frame.index), examination.error());
  if (auto done = score_frame(run, tracked, *examination); !done) return done;
  if (!run.removed_files) {
    const auto removed = remove_files_of_detect(run.arguments.out);
    if (!removed) return fail(removed.error());
    run.removed_files = *removed;
  }
  if (auto done = write_images(run, tracked.frame.index, examination->comparison); !done) return done;
  if (auto done = write_views(run, tracked, *examination, stages.views); !done) return done;
  if (auto done = run.pictures.update(tracked, *examination, stages.views, false); !done) return done;
  run.total_ms.push_back(examination->total_ms);
  run.results.push_back(frame_json(run, *frame, *examination));
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

// "frame 3: 12 closer, 7 unmodelled pixels; regions: 1 confirmed, 2 not yet; smallest visible change: 7.9 mm"
std::string frame_text(const nlohmann::json& frame) {
  const auto& regions = frame["regions"];
  const auto confirmed = std::count_if(regions.begin(), regions.end(),
                                       [](const nlohmann::json& region) { return region["confirmed"].get<bool>(); });
  std::string text =
      fmt::format("frame {}: {} pixels; regions: {} confirmed, {} not yet", frame["index"].get<int>(),
                  changes_text(frame["counts"]), confirmed, static_cast<std::ptrdiff_t>(regions.size()) - confirmed);
  if (frame.contains("averaged_frames")) text += fmt::format("; mean of {}", frame["averaged_frames"].get<int>());
  const auto& smallest = frame["smallest_change_m"];
  if (smallest.is_number())
    return text + fmt::format("; smallest visible change: {:.1f} mm", 1000 * smallest.get<double>());
  return text + "; " + frame["why_nothing"].get<std::string>();
}

std::string score_text(const LabelScore& score) {
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{:.3f}", value) : "none"; };
  return fmt::format("against the truth: IoU closer {}, farther {}, unmodelled {}; recall {}, false change {}",
                     number(score.iou(Label::closer)), number(score.iou(Label::farther)),
                     number(score.iou(Label::unmodelled)), number(score.recall()), number(score.false_change()));
}

/// `done`: how the run ended; the frames before an error are told too.
void report(const DetectRun& run, const ImportedModel& model, const Status& done) {
  nlohmann::json json{{"frames", run.results}, {"time_ms", spread_json(run.total_ms)}, {"model", import_json(model)}};
  json["removed_files"] = run.removed_files.value_or(0);
  if (run.score) json["truth"] = score_json(*run.score);
  if (!done) json["error"] = done.error().message;
  if (run.arguments.json) {
    print_json(json);
    return;
  }
  std::cout << import_text(run.arguments.model.file, model) << '\n';
  if (run.removed_files.value_or(0) > 0) {
    std::cout << fmt::format("removed {} files of an earlier run from {}\n", *run.removed_files, run.arguments.out);
  }
  for (const auto& frame : run.results) {
    if (!frame.contains("counts")) {
      std::cout << fmt::format("frame {}: the pose is lost\n", frame["index"].get<int>());
      continue;
    }
    std::cout << frame_text(frame) << '\n';
  }
  if (run.score) std::cout << score_text(*run.score) << '\n';
  if (!run.total_ms.empty()) std::cout << "pictures and differences are in " << run.arguments.out << '\n';
}

// The mean of the frames that were collected, in place of the first one's depth.
void begin_average(DetectRun& run, Stages& stages) {
  if (!run.first_of_average) return;
  AveragedDepth average = run.average->result();
  TrackedFrame tracked = std::move(*run.first_of_average);
  tracked.frame.depth = average.mean;
  run.average->reset();
  run.first_of_average.reset();
  begin_frame(run, std::move(tracked), std::move(average), stages);
}

Status begin_or_collect(DetectRun& run, TrackedFrame tracked, Stages& stages) {
  const bool is_lost = tracked.depth_pose.state == TrackState::lost;
  if (!run.average || is_lost) {
    begin_frame(run, std::move(tracked), std::nullopt, stages);
    return {};
  }
  if (auto done = run.average->add(tracked.frame.depth, tracked.depth_pose); !done) {
    return fail(fmt::format("frame {}", tracked.frame.index), done.error());
  }
  if (!run.first_of_average) run.first_of_average = std::move(tracked);
  if (run.average->count() == run.arguments.average) begin_average(run, stages);
  return {};
}

Status process(DetectRun& run, TrackedFrames& frames, Stages& stages) {
  int read = 0;
  for (;;) {
    auto tracked = frames.next();  // while the frame before is compared
    if (auto done = finish_frame(run, stages); !done) return done;
    if (!tracked) return fail(tracked.error());
    if (!*tracked) break;
    read = (*tracked)->frame.index + 1;
    const bool wanted = run.frames.empty() || std::binary_search(run.frames.begin(), run.frames.end(), read - 1);
    if (wanted) {
      if (auto done = begin_or_collect(run, std::move(**tracked), stages); !done) return done;
    }
    if (!run.frames.empty() && read > run.frames.back()) break;
  }
  if (auto done = finish_frame(run, stages); !done) return done;
  begin_average(run, stages);  // of what is left
  return finish_frame(run, stages);
}

Status detect_all(DetectRun& run, const ImportedModel& imported, TrackedFrames& frames, Stages& stages) {
  auto done = process(run, frames, stages);
  const auto is_found = [](const nlohmann::json& frame) { return frame.contains("counts"); };
  if (done && std::none_of(run.results.begin(), run.results.end(), is_found)) done = fail(kEveryFrameIsLost);
  // A mean of frames is told by its first one, after those that were lost meanwhile.
  std::sort(run.results.begin(), run.results.end(),
            [](const nlohmann::json& a, const nlohmann::json& b) { return a["index"] < b["index"]; });
  if (!run.results.empty()) report(run, imported, done);
  return done;
}

Status detect(const DetectArguments& arguments) {
  DetectRun run{.arguments = arguments,
                .frames = {},
                .pictures = RegionPictures{arguments.out},
                .average = std::nullopt,
                .first_of_average = std::nullopt,
                .score = std::nullopt,
                .results = nlohmann::json::array(),
                .total_ms = {},
                .removed_files = std::nullopt};
  auto options = arguments.threshold.examiner_options();
  if (!options) return fail(options.error());
  options->wait_for_detail = true;
  if (!arguments.frames.empty()) {
    auto list = parse_frame_list(arguments.frames);
    if (!list) return fail(list.error());
    run.frames = std::move(*list);
  }
  const auto imported = arguments.model.import();
  if (!imported) return fail(imported.error());
  auto frames = arguments.recording.open();
  if (!frames) return fail(frames.error());
  if (auto there = frames->check_frames(run.frames); !there) return there;
  std::error_code error;
  fs::create_directories(arguments.out, error);
  if (error) return fail(fmt::format("cannot make the folder '{}': {}", arguments.out, error.message()));
  if (arguments.average > 1) run.average.emplace(frames->rig().depth, frames->rig().sensor);
  if (!arguments.truth.empty()) run.score.emplace(frames->rig().sensor, 3.0);
  auto examiner = Examiner::create(frames->rig(), *options);
  if (!examiner) return fail(examiner.error());
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto views = Views::create(**gpu, frames->rig(), arguments.views);
  if (!views) return fail(views.error());
  Stages stages{imported->model, *examiner, *views};
  return detect_all(run, *imported, *frames, stages);
}

}  // namespace

void add_detect_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<DetectArguments>();
  CLI::App* command = app.add_subcommand("detect", "compare a recording with a model, in batch");
  arguments->model.add_to(*command, "--model");
  arguments->recording.add_to(*command, true);
  command->add_option("--frames", arguments->frames, "frames to compare, from 0, such as 0,5,10-20; all if not given");
  arguments->threshold.add_to(*command);
  command
      ->add_option("--average", arguments->average,
                   "compare the mean of this many frames, during which the camera rests")
      ->check(CLI::Range(1, FrameAverage::kMostFrames))
      ->capture_default_str();
  command
      ->add_option("--out", arguments->out,
                   "folder for differences, labels, overlays and a picture of each region; those of an earlier run in "
                   "it are removed")
      ->required();
  command->add_option("--truth", arguments->truth, "folder of exact depth images (made by simulate): adds a score");
  arguments->views.views = "both";
  arguments->views.add_to(*command);
  command->add_flag("--json", arguments->json, "results as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return detect(*arguments); }; });
}

}  // namespace meshloop
