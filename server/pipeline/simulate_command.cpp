// `simulate`: recordings of a virtual scene, with ground truth.
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <iostream>
#include <memory>

#include "common/program/arguments.h"
#include "common/simulation/demo_data.h"
#include "server/pipeline/commands.h"

namespace meshloop {
namespace {

struct SimulateArguments {
  std::string out;
  simulation::DemoOptions options;
  std::string color_size = "640x480";
  std::string depth_size = "640x480";
};

Result<simulation::DemoRig::Size> parse_size(const std::string& text) {
  simulation::DemoRig::Size size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  const bool has_cross = width.ec == std::errc{} && width.ptr != end && *width.ptr == 'x';
  const auto height = has_cross ? std::from_chars(width.ptr + 1, end, size.height) : width;
  if (has_cross && height.ec == std::errc{} && height.ptr == end) return size;
  return fail(fmt::format("'{}' is not a size of pictures; write 320x240", text), ErrorKind::usage);
}

void show_progress(int done, int all) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::cerr << fmt::format("\rsimulating {} of {} pictures", done, all) << (done == all ? "\n" : "") << std::flush;
}

Status simulate(SimulateArguments arguments) {
  const auto color = parse_size(arguments.color_size);
  if (!color) return fail("--color-size", color.error());
  const auto depth = parse_size(arguments.depth_size);
  if (!depth) return fail("--depth-size", depth.error());
  arguments.options.rig.color = *color;
  arguments.options.rig.depth = *depth;
  if (auto done = simulation::write_demo_data(arguments.out, arguments.options, show_progress); !done) return done;
  std::cout << fmt::format("recordings, models, markers and ground truth are in {}\n", arguments.out);
  return {};
}

}  // namespace

void add_simulate_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = app.add_subcommand("simulate", "record a virtual scene, with ground truth");
  command->add_option("--out", arguments->out, "folder for recordings, model and ground truth")->required();
  command->add_option("--noise", arguments->options.noise, "1: a Kinect's noise, 0: none")
      ->check(between(0, 10))
      ->capture_default_str();
  command->add_option("--seed", arguments->options.seed, "seed of noise and textures")->capture_default_str();
  command->add_option("--station-frames", arguments->options.station_frames, "frames of the station's recording")
      ->check(CLI::Range(12, 10'000))
      ->capture_default_str();
  command->add_option("--device-frames", arguments->options.device_frames, "frames of each of the device's recordings")
      ->check(CLI::Range(2, 10'000))
      ->capture_default_str();
  command->add_option("--color-size", arguments->color_size, "pixels of the colour images")->capture_default_str();
  auto* const depth_size =
      command->add_option("--depth-size", arguments->depth_size, "pixels of the depth images")->capture_default_str();
  command
      ->add_flag("--registered", arguments->options.rig.registered,
                 "depth in the colour camera's pixels, and as many of them")
      ->excludes(depth_size);
  command->add_flag("--float-depth", arguments->options.rig.float_depth, "depth as 32-bit float TIFF, in metres");
  command->callback([arguments, &action] { action = [arguments] { return simulate(*arguments); }; });
}

}  // namespace meshloop
