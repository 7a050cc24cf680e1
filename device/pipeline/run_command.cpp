// `run`: the live client.
#include <fmt/format.h>

#include <fstream>
#include <iostream>
#include <memory>

#include "common/program/arguments.h"
#include "common/program/json_output.h"
#include "common/program/stop_signal.h"
#include "device/capture/recording_source.h"
#include "device/pipeline/commands.h"
#include "device/pipeline/live_client.h"
#include "device/pipeline/object_arguments.h"

namespace meshloop {
namespace {

struct RunArguments {
  LiveOptions live;
  ObjectArguments object;
  std::string camera;
  std::string display;
  std::string init;
  std::string poses_out;
  std::string report;
  double seconds = 0;
  int every = 1;
  bool loop = false;
};

Result<std::unique_ptr<Presenter>> open_display(const RunArguments& arguments) {
  const auto [kind, folder] = split_kind(arguments.display);
  if (kind != "offscreen" || folder.empty()) {
    return fail(fmt::format("unknown display '{}'; this version takes offscreen:DIR", arguments.display),
                ErrorKind::usage);
  }
  auto presenter = OffscreenPresenter::create({.folder = folder, .every_nth = arguments.every});
  if (!presenter) return fail(presenter.error());
  return std::unique_ptr<Presenter>{std::move(*presenter)};
}

Result<std::string> camera_folder(const std::string& camera) {
  const auto [kind, folder] = split_kind(camera);
  if (kind == "recording" && !folder.empty()) return folder;
  return fail(fmt::format("unknown camera '{}'; this version takes recording:DIR", camera), ErrorKind::usage);
}

Status write_results(const RunArguments& arguments, const LiveClient& client, const std::optional<Trajectory>& truth) {
  if (!arguments.poses_out.empty()) {
    if (auto done = write_trajectory(arguments.poses_out, client.session().trajectory()); !done) return done;
  }
  const auto report = client.report(truth);
  if (!arguments.report.empty()) {
    std::ofstream file{arguments.report};
    file << json_page(report);
    if (!file.flush()) return fail(fmt::format("cannot write '{}'", arguments.report));
  }
  if (!arguments.live.json) {
    std::cout << fmt::format("{} frames drawn, {} lost, revision {}\n", client.session().records().size(),
                             client.session().lost_frames(), json_line(report["revision"]));
  }
  return {};
}

Status run(RunArguments arguments) {
  const auto folder = camera_folder(arguments.camera);
  if (!folder) return fail(folder.error());
  auto start = StartPose::parse(arguments.init);
  if (!start) return fail(start.error());
  auto camera = ColorRecordingSource::open(*folder, std::nullopt, {.real_time = true, .loop = arguments.loop});
  if (!camera) return fail(camera.error());
  auto display = open_display(arguments);
  if (!display) return fail(display.error());
  const auto object = arguments.object.make();
  if (!object) return fail(object.error());
  arguments.live.objects = {*object};
  catch_stop_signals();
  auto client = LiveClient::create(arguments.live, (*camera)->camera(), std::move(*start), std::move(*display));
  if (!client) return fail(client.error());
  const auto ran = (*client)->run(**camera, arguments.seconds);
  const auto written = write_results(arguments, **client, (*camera)->recording().ground_truth());
  if (!ran) return ran;
  if (!written) return written;
  return (*client)->has_scene() ? Status{} : fail(no_scene_yet(arguments.live.link));
}

}  // namespace

void add_run_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* command = app.add_subcommand("run", "the live client: receive, track, draw");
  command->add_option("--scene", arguments->live.link.scene, "name of the scene on the network")->required();
  command->add_option("--camera", arguments->camera, "recording:DIR, played at its recorded pace")->required();
  command->add_option("--display", arguments->display, "offscreen:DIR writes the pictures as PNG")->required();
  command->add_option("--init", arguments->init, kInitHelp)->required();
  command->add_option("--domain", arguments->live.link.domain, "DDS domain")
      ->check(CLI::Range(0, 230))
      ->capture_default_str();
  arguments->object.add_to(*command);
  command->add_option("--every", arguments->every, "write every n-th picture only")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_flag("--loop", arguments->loop, "play the recording again when it ends");
  command->add_option("--seconds", arguments->seconds, "end after this time; 0: when the camera ends")
      ->check(between(0, 1e9))
      ->capture_default_str();
  command->add_option("--poses-out", arguments->poses_out, "file for the poses (TUM format, camera to world)");
  command->add_option("--report", arguments->report, "file for the JSON report");
  command->add_flag("--json", arguments->live.json, "a JSON document a line on stdout for each revision that is drawn");
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace meshloop
