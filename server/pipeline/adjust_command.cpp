// `adjust`: snapshots to new revisions, in batch.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/program/arguments.h"
#include "common/recording/recording.h"
#include "server/pipeline/adjust_report.h"
#include "server/pipeline/adjuster.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/decisions.h"
#include "server/pipeline/operator_name.h"
#include "server/pipeline/options.h"
#include "server/pipeline/proposal_pictures.h"
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
  std::string reject;
  std::string reason;
  std::string out;
  OperatorArguments person;
  SurfaceArguments surface;
  ViewArguments views;
  bool json = false;
};

struct AdjustRun {
  std::vector<int> frames;
  Decisions decisions;
  /// For the journal.
  std::string author;
  std::string calibration;
  AdjustOptions options;
  /// Frames that may be fused with a listed one.
  RecentDepths recent{1};
  std::optional<TrackedPose> previous_pose;
  std::vector<AdjustedFrame> results;
};

/// What a frame is adjusted with.
struct Tools {
  const Rig* rig;
  Examiner* examiner;
  Views* views;
  const ProposalPictures* pictures;
  SceneStore* store;
};

Status read_decisions(const AdjustArguments& arguments, AdjustRun& run) {
  Decisions& decisions = run.decisions;
  if (auto ok = parse_accept(arguments.accept, "--accept", decisions); !ok) return ok;
  if (!decisions.accept.empty() && run.frames.size() != 1) {
    return fail("--accept with ids needs a single frame in --frames", ErrorKind::usage);
  }
  if (!arguments.reject.empty()) {
    auto ids = parse_proposal_ids(arguments.reject);
    if (!ids) return fail("--reject", ids.error());
    decisions.reject = std::move(*ids);
  }
  if (!arguments.reason.empty() && decisions.reject.empty()) {
    return fail("--reason says why something is rejected; name it with --reject", ErrorKind::usage);
  }
  decisions.reason = arguments.reason;
  for (const auto id : decisions.accept) {
    if (std::find(decisions.reject.begin(), decisions.reject.end(), id) == decisions.reject.end()) continue;
    return fail(fmt::format("proposal {} is accepted and rejected at once", id), ErrorKind::usage);
  }
  return {};
}

Result<AdjustRun> make_run(const AdjustArguments& arguments) {
  AdjustRun run;
  auto frames = parse_frame_list(arguments.frames);
  if (!frames) return fail(frames.error());
  run.frames = std::move(*frames);
  run.options = arguments.surface.adjust_options();
  run.recent = RecentDepths{static_cast<std::size_t>(arguments.surface.fuse)};
  run.author = arguments.person.name;
  if (auto ok = read_decisions(arguments, run); !ok) return fail(ok.error());
  return run;
}

/// Under their ids. A scene that cannot be written is only looked at, as long as nothing is to be decided.
Result<std::vector<Offered>> identify(AdjustRun& run, SceneStore& store, std::vector<Proposal> proposals) {
  const Decisions& decisions = run.decisions;
  const bool decides = decisions.accept_all || !decisions.accept.empty() || !decisions.reject.empty();
  auto offered = remember_proposals(store, proposals);
  if (offered || decides) return offered;
  log_warning("{}; new proposals have no ids", offered.error().message);
  return recognise_proposals(store, std::move(proposals));
}

Status draw_proposals(AdjustedFrame& result, const TrackedFrame& tracked, const Examination& examination,
                      const Tools& tools) {
  if (!tools.pictures->wanted()) return {};
  for (const auto& offered : result.offered) {
    if (offered.record.id == 0) {  // they would have one name
      result.pictures.emplace_back(nullptr);
      continue;
    }
    const auto file = tools.pictures->write(tracked, examination, offered, *tools.views);
    if (!file) return fail(file.error());
    result.pictures.push_back({{"proposal", *file}, {"before", nullptr}, {"after", nullptr}});
  }
  return {};
}

Status draw_after(AdjustedFrame& result, const TrackedFrame& tracked, const Examination& before, const Tools& tools) {
  if (!tools.pictures->wanted()) return {};
  tools.examiner->model_changed();
  const auto after = tools.examiner->examine(tracked, *tools.store->model());
  if (!after) return fail(after.error());
  for (std::size_t i = 0; i < result.offered.size(); ++i) {
    if (result.offered[i].record.state != ProposalState::accepted) continue;
    const auto file = tools.pictures->write_after(tracked, before, *after, result.offered[i], result.revision->revision,
                                                  *tools.views);
    if (!file) return fail(file.error());
    result.pictures[i]["before"] = result.pictures[i]["proposal"];
    result.pictures[i]["after"] = *file;
  }
  return {};
}

Status accept(AdjustRun& run, AdjustedFrame& result, const TrackedFrame& tracked, const Examination& examination,
              const Registration& registration, const Tools& tools) {
  SceneStore& store = *tools.store;
  if (auto done = reject_known(store, run.author, run.decisions); !done) return done;
  auto known = store.proposals();
  if (!known) return fail(known.error());
  refresh(*known, result.offered);
  const auto accepted = chosen(run.decisions, result.offered, *known);
  if (!accepted) return fail(accepted.error());
  if (accepted->empty()) return {};
  const auto framing = framing_of(examination.regions, result.offered);
  auto picture = tools.views->on_color(tracked, examination, fmt::format("frame {}", tracked.frame.index), &framing);
  if (!picture) return fail(picture.error());
  const Evidence evidence{run.author, snapshot_info(tracked, registration, run.calibration), std::move(*picture)};
  const auto acceptance = accept_changes(store, *accepted, evidence);
  if (!acceptance) return fail(acceptance.error());
  result.revision = acceptance->info;
  if (auto synced = store.sync(); !synced) {
    return fail(fmt::format("revision {} may be gone at the next start", acceptance->info.revision), synced.error());
  }
  if (known = store.proposals(); !known) return fail(known.error());
  refresh(*known, result.offered);
  return draw_after(result, tracked, examination, tools);
}

/// `against`: why nothing may be proposed from this frame, if that is known before it is looked at.
Status adjust_frame(AdjustRun& run, const TrackedFrame& tracked, const std::optional<std::string>& against,
                    const Tools& tools) {
  AdjustedFrame& result = run.results.emplace_back();
  result.index = tracked.frame.index;
  // Nothing is proposed from a view that is not where it says.
  const auto withhold = [&](const std::string& reason) -> Status {
    run.recent.drop(result.index);
    if (!run.decisions.accept.empty()) return fail(reason);
    result.reason = reason;
    return {};
  };
  if (against) return withhold(*against);
  tools.examiner->model_changed();  // each listed frame stands for itself
  auto examination = tools.examiner->examine(tracked, *tools.store->model());
  if (!examination) return fail(examination.error());
  const Stopwatch watch;
  auto changes =
      propose_changes(tracked, *examination, run.recent.before(tracked, 0), *tools.rig, *tools.store, run.options);
  result.details = {{"frames_fused", changes.frames},
                    {"time_ms", {{"snapshot", watch.milliseconds()}}},
                    {"edge_rings", rings_json(changes.rings)},
                    {"joint_poses", joint_json(changes.joint)},
                    {"registration", registration_json(changes.registration, tracked.depth_pose)}};
  if (changes.withheld) return withhold(changes.withheld->reason);
  auto offered = identify(run, *tools.store, std::move(changes.proposals));
  if (!offered) return fail(offered.error());
  result.offered = std::move(*offered);
  if (auto done = draw_proposals(result, tracked, *examination, tools); !done) return done;
  return accept(run, result, tracked, *examination, changes.registration, tools);
}

/// `done`: how the run ended; the frames before an error are told too, for their revisions stay.
void report(const AdjustArguments& arguments, const AdjustRun& run, const Model& model, const Status& done) {
  if (!arguments.json) {
    for (const auto& frame : run.results) std::cout << frame_text(frame);
    return;
  }
  auto frames = nlohmann::json::array();
  for (const auto& frame : run.results) frames.push_back(frame_json(frame));
  nlohmann::json json{{"frames", frames}, {"revision", model.revision}, {"triangles", model.triangle_count()}};
  if (!done) json["error"] = done.error().message;
  print_json(json);
}

Status adjust_all(AdjustRun& run, TrackedFrames& frames, const Tools& tools) {
  int read = 0;
  while (read <= run.frames.back()) {
    auto tracked = frames.next();
    if (!tracked) return fail(tracked.error());
    if (!*tracked) break;
    read = (*tracked)->frame.index + 1;
    const bool is_sharp = !reason_to_wait(**tracked, run.previous_pose, frames.rig());
    const auto against = reason_against(**tracked, run.previous_pose, frames.rig());
    run.previous_pose = (*tracked)->depth_pose;
    if (is_sharp) run.recent.add(**tracked);
    if (!std::binary_search(run.frames.begin(), run.frames.end(), read - 1)) continue;
    if (auto done = adjust_frame(run, **tracked, against, tools); !done) {
      if (!run.results.back().revision) run.results.pop_back();
      return fail(fmt::format("frame {}", read - 1), done.error());
    }
  }
  return check_all_rejected(run.decisions);
}

/// Fails when none of the frames could be used.
Status check_any_used(const AdjustRun& run) {
  std::optional<std::string> first;
  for (const auto& frame : run.results) {
    if (frame.reason.empty()) return {};
    if (frame.reason != kPoseIsLost && !first) first = fmt::format("frame {}: {}", frame.index, frame.reason);
  }
  return first ? fail("no frame could be used; " + *first) : fail(kEveryFrameIsLost);
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
  run->calibration = rig_text(frames->calibration());
  options->regions.confirm_views = 1;
  auto examiner = Examiner::create(frames->rig(), *options);
  if (!examiner) return fail(examiner.error());
  auto gpu = GpuContext::create_headless();
  if (!gpu) return fail(gpu.error());
  auto views = Views::create(**gpu, frames->rig(), arguments.views);
  if (!views) return fail(views.error());
  const auto pictures = ProposalPictures::create(arguments.out);
  if (!pictures) return fail(pictures.error());
  if (auto done = reject_known(**store, run->author, run->decisions); !done) return done;
  auto done = adjust_all(*run, *frames, {&frames->rig(), &*examiner, &*views, &*pictures, store->get()});
  if (done) done = check_any_used(*run);
  if (auto synced = (*store)->sync(); !synced && done) done = synced;
  if (!run->results.empty()) report(arguments, *run, *(*store)->model(), done);
  return done;
}

std::string check_reason(const std::string& text) {
  return text.empty() ? std::string{} : why_not_one_line(text, "a reason", kLongestReason);
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
  command->add_option(
      "--accept", arguments->accept,
      "all that is not rejected, or ids of proposals (1,3) that the one frame shows; nothing is accepted "
      "if not given. A proposal keeps its id in later frames and runs");
  command->add_option("--reject", arguments->reject,
                      "ids of proposals (2,4) that `--accept all` and `run` leave out from now on, as long as what is "
                      "measured there stays the same; --accept with the id takes it back");
  command->add_option("--reason", arguments->reason, "why, for --reject: one line")
      ->check(CLI::Validator{check_reason, ""});
  command->add_option(
      "--out", arguments->out,
      "folder for pictures: proposal_ID.png of each proposal, and proposal_ID_after.png of each one that "
      "is accepted");
  arguments->surface.add_to(*command);
  arguments->person.add_to(*command);
  arguments->views.add_colors_to(*command);
  command->add_flag("--json", arguments->json, "proposals and revisions as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return adjust(*arguments); }; });
}

}  // namespace meshloop
