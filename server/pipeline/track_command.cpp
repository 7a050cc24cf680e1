// `track`: camera poses of a recording, without the model.
#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "server/pipeline/commands.h"
#include "server/pipeline/options.h"
#include "server/pipeline/result_json.h"

namespace meshloop {
namespace {

struct TrackArguments {
  RecordingArguments recording;
  std::string out;
  bool json = false;
};

nlohmann::json pose_json(const TrackedFrame& tracked) {
  const auto& pose = tracked.color_pose;
  return {{"index", tracked.frame.index}, {"timestamp", tracked.frame.color_timestamp_s},
          {"state", name_of(pose.state)}, {"quality", pose.quality},
          {"inliers", pose.inliers},      {"time_ms", tracked.track_ms}};
}

Status track(const TrackArguments& arguments) {
  auto frames = arguments.recording.open();
  if (!frames) return fail(frames.error());
  Trajectory trajectory;
  nlohmann::json results = nlohmann::json::array();
  std::vector<double> times;
  std::size_t lost = 0;
  for (;;) {
    auto tracked = frames->next();
    if (!tracked) return fail(tracked.error());
    if (!*tracked) break;
    const TrackedFrame& frame = **tracked;
    results.push_back(pose_json(frame));
    times.push_back(frame.track_ms);
    if (frame.color_pose.state == TrackState::lost) {
      ++lost;
    } else {
      trajectory.push_back({frame.frame.color_timestamp_s, frame.color_pose.T_camera_world.inverse()});
    }
  }
  if (auto done = write_trajectory(arguments.out, trajectory); !done) return done;
  if (arguments.json) {
    print_json({{"frames", results}, {"lost", lost}, {"time_ms", spread_json(times)}});
  } else {
    std::cout << fmt::format("{} of {} frames tracked, {} lost; poses are in {}\n", trajectory.size(), results.size(),
                             lost, arguments.out);
  }
  return {};
}

}  // namespace

void add_track_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<TrackArguments>();
  CLI::App* command = app.add_subcommand("track", "camera poses of a recording, without the model");
  arguments->recording.add_to(*command, false);
  command->add_option("--out", arguments->out, "file for the poses (TUM format, camera to world)")->required();
  command->add_flag("--json", arguments->json, "per-frame state and time as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return track(*arguments); }; });
}

}  // namespace meshloop
