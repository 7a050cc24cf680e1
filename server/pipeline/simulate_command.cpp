// `simulate`: recordings of a virtual scene, with ground truth.
#include <fmt/format.h>
#include <unistd.h>

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
};

void show_progress(int done, int all) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::cerr << fmt::format("\rsimulating {} of {} pictures", done, all) << (done == all ? "\n" : "") << std::flush;
}

Status simulate(const SimulateArguments& arguments) {
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
  command->callback([arguments, &action] { action = [arguments] { return simulate(*arguments); }; });
}

}  // namespace meshloop
