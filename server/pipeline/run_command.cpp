// `run`: the live station.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <memory>

#include "common/program/arguments.h"
#include "common/program/stop_signal.h"
#include "common/recording/recording.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/options.h"
#include "server/pipeline/station.h"

namespace meshloop {
namespace {

struct RunArguments {
  StationOptions station;
  RecordingArguments recording;
  std::string source;
  std::string scene;
  std::string out;
  ThresholdArguments threshold;
  OperatorArguments person;
  SurfaceArguments surface;
  std::string accept = "none";
  std::optional<double> sure_confidence;
  std::optional<double> sure_change_m;
  bool fast = false;
};

Status set_rule(const RunArguments& arguments, AcceptanceRule& rule) {
  rule.what = arguments.accept == "all"    ? AcceptanceRule::What::all
              : arguments.accept == "sure" ? AcceptanceRule::What::sure
                                           : AcceptanceRule::What::none;
  const bool says_how_sure = arguments.sure_confidence.has_value() || arguments.sure_change_m.has_value();
  if (says_how_sure && rule.what != AcceptanceRule::What::sure) {
    return fail("--sure-confidence and --sure-change are for --accept sure", ErrorKind::usage);
  }
  rule.least_confidence = arguments.sure_confidence.value_or(rule.least_confidence);
  rule.largest_change_m = arguments.sure_change_m.value_or(rule.largest_change_m);
  return {};
}

Status run(RunArguments arguments) {
  if (arguments.station.commands && ::fcntl(STDIN_FILENO, F_GETFD) < 0) {
    return fail("--commands are read from standard input, which is closed", ErrorKind::usage);
  }
  const auto [kind, folder] = split_kind(arguments.source);
  if (kind != "recording" || folder.empty()) {
    return fail(fmt::format("unknown source '{}'; this version takes recording:DIR", arguments.source),
                ErrorKind::usage);
  }
  arguments.recording.recording = folder;
  const auto examiner = arguments.threshold.examiner_options();
  if (!examiner) return fail(examiner.error());
  auto& options = arguments.station;
  options.examiner = *examiner;
  // Who is not bound to a pace wants the same result each time.
  options.examiner.wait_for_detail = arguments.fast;
  options.scene = arguments.scene;
  options.out = arguments.out;
  if (auto ok = set_rule(arguments, options.accept); !ok) return ok;
  options.operator_name = arguments.person.name;
  options.frames_fused = arguments.surface.fuse;
  options.adjust = arguments.surface.adjust_options();
  if (options.link.scene.empty()) options.link.scene = options.scene.stem().string();
  auto frames = arguments.recording.open(true, !arguments.fast);
  if (!frames) return fail(frames.error());
  catch_stop_signals();
  options.calibration = rig_text(frames->calibration());
  auto station = Station::create(options, frames->rig());
  if (!station) return fail(station.error());
  return (*station)->run(*frames);
}

}  // namespace

void add_run_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "the live station: track, compare, adjust, store, publish");
  command->add_option("--scene", arguments->scene, "the scene file (made by `scene import`)")->required();
  command->add_option("--source", arguments->source, "recording:DIR, played at its recorded pace")->required();
  arguments->recording.add_source_options(*command);
  command->add_option("--name", arguments->station.link.scene,
                      "the scene's name on the network; the file's name if not given");
  command->add_option("--domain", arguments->station.link.domain, "DDS domain")
      ->check(CLI::Range(0, 230))
      ->capture_default_str();
  arguments->threshold.add_to(*command);
  command
      ->add_option(
          "--accept", arguments->accept,
          "what is accepted without asking, of what is confirmed while the pose is certain and the camera slow: "
          "none, all, or what is sure (below). Never what somebody rejected or undid")
      ->check(CLI::IsMember({"none", "all", "sure"}))
      ->capture_default_str();
  command
      ->add_option("--sure-confidence", arguments->sure_confidence,
                   "sure has at least this confidence: of a move, the share of the measurements that it explains; of a "
                   "removal, the share of the removed surface in sight that is seen through; of new surface, how "
                   "improbable it is as noise (0.9 if not given)")
      ->check(between(0, 1));
  command
      ->add_option("--sure-change", arguments->sure_change_m,
                   "and changes the model by at most so many metres; new surface where the model has nothing behind it "
                   "is not sure (0.3 if not given)")
      ->check(between(0.001, 100));
  command->add_flag("--commands", arguments->station.commands,
                    "take commands from standard input, one a line: accept all, accept 1,3, reject 2 WHY, undo, redo, "
                    "list; what is proposed is told with its ids. undo and redo never empty the model");
  arguments->surface.fuse = 8;
  arguments->surface.add_to(*command);
  arguments->person.add_to(*command);
  command->add_option("--out", arguments->out,
                      "folder for pictures before and after each revision, and of each confirmed region");
  arguments->station.views.add_to(*command);
  command
      ->add_option("--serve", arguments->station.serve_s,
                   "seconds to go on serving when the source has ended; -1: until Ctrl-C")
      ->check(between(-1, 1e9))
      ->capture_default_str();
  command->add_flag("--fast", arguments->fast, "play the recording as fast as it can be worked on");
  command->add_flag("--json", arguments->station.json, "one JSON document a line on stdout for each event");
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace meshloop
