// `calibrate --noise`: the sensor's noise, from a recording of a scene at rest.
#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "common/image/rectifier.h"
#include "common/recording/recording.h"
#include "server/calibrate/noise_measurement.h"
#include "server/pipeline/commands.h"
#include "server/pipeline/result_json.h"

namespace meshloop {
namespace {

struct CalibrateArguments {
  bool noise = false;
  std::string recording;
  std::string out;
  bool json = false;
};

// Evenly over the recording, at most as many frames as the measurement takes.
Result<MeasuredNoise> measure_noise(const Recording& recording) {
  const Rectifier rectify{recording.rig().depth};
  NoiseMeasurement measurement{recording.rig().depth.without_distortion()};
  const auto frames = static_cast<int>(recording.depth_images().size());
  const int every = (frames + NoiseMeasurement::kMostFrames - 1) / NoiseMeasurement::kMostFrames;
  for (int index = 0; index < frames; index += every) {
    const auto frame = recording.read_frame(index);
    if (!frame) return fail(frame.error());
    if (auto done = measurement.add(rectify.rectify(frame->depth)); !done) return fail(done.error());
  }
  return measurement.fit();
}

void report(const CalibrateArguments& arguments, const MeasuredNoise& noise) {
  const SensorNoise& model = noise.model.noise();
  nlohmann::json bins = nlohmann::json::array();
  for (const NoiseBin& bin : noise.bins) {
    bins.push_back({{"z_m", bin.z_m},
                    {"sigma_m", bin.sigma_m},
                    {"fitted_m", noise.model.sigma_z_m(bin.z_m, 0)},
                    {"step_m", bin.step_m},
                    {"pixels", bin.pixels}});
  }
  if (arguments.json) {
    print_json({{"bins", bins},
                {"polynomial", {model.axial[0], model.axial[1], model.axial[2]}},
                {"range_m", {model.nearest_m, model.farthest_m}},
                {"step_per_m", model.step_per_m},
                {"lateral_px", model.lateral_px},
                {"lateral_measured", noise.edges >= NoiseMeasurement::kLeastEdges},
                {"worst_fit", noise.worst_fit},
                {"rig", arguments.out}});
    return;
  }
  std::cout << "  depth     sigma    fitted     steps    pixels\n";
  for (const NoiseBin& bin : noise.bins) {
    std::cout << fmt::format("{:5.2f} m  {:5.2f} mm  {:5.2f} mm  {:5.2f} mm  {:8}\n", bin.z_m, 1e3 * bin.sigma_m,
                             1e3 * noise.model.sigma_z_m(bin.z_m, 0), 1e3 * bin.step_m, bin.pixels);
  }
  std::cout << fmt::format("across the axis: {:.2f} pixels{}\n", model.lateral_px,
                           noise.edges >= NoiseMeasurement::kLeastEdges
                               ? fmt::format(", at {} depth edges", noise.edges)
                               : " (a Kinect's; the scene shows too few depth edges to measure it)")
            << fmt::format("the fit is off by {:.0f} % at most, and holds from {:.2f} to {:.2f} m\n",
                           1e2 * noise.worst_fit, model.nearest_m, model.farthest_m)
            << "the rig with this sensor is in '" << arguments.out << "'; use it with --rig\n";
}

Status calibrate(const CalibrateArguments& arguments) {
  if (!arguments.noise) {
    return fail("say what to calibrate; this version measures the depth sensor's --noise", ErrorKind::usage);
  }
  const auto recording = Recording::open(arguments.recording);
  if (!recording) return fail(recording.error());
  if (recording->depth_images().empty()) {
    return fail(fmt::format("the recording '{}' has no depth.txt", arguments.recording));
  }
  const auto noise = measure_noise(*recording);
  if (!noise) return fail(noise.error());
  Rig rig = recording->rig();
  rig.sensor = noise->model;
  if (auto done = write_rig(arguments.out, rig); !done) return done;
  report(arguments, *noise);
  return {};
}

}  // namespace

void add_calibrate_command(CLI::App& app, Action& action) {
  auto arguments = std::make_shared<CalibrateArguments>();
  CLI::App* command = app.add_subcommand("calibrate", "measure the depth sensor's noise from a scene at rest");
  command->add_flag("--noise", arguments->noise, "noise by depth, steps, and noise across the optical axis");
  command->add_option("--recording", arguments->recording, "at least 20 frames, the camera on a tripod")->required();
  command->add_option("--out", arguments->out, "the recording's rig.yaml with the measured sensor")->required();
  command->add_flag("--json", arguments->json, "results as JSON on stdout");
  command->callback([arguments, &action] { action = [arguments] { return calibrate(*arguments); }; });
}

}  // namespace meshloop
