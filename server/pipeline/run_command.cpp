// `run`: the live station.
#include <fmt/format.h>

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
  bool fast = false;
};

Status run(RunArguments arguments) {
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
  options.accept_all = arguments.accept == "all";
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
      ->add_option("--accept", arguments->accept, "what is accepted without asking: all confirmed proposals, or none")
      ->check(CLI::IsMember({"all", "none"}))
      ->capture_default_str();
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
