// `doctor`: is all there that the device client needs?
#include <fmt/format.h>

#include <iostream>

#include "common/gpu/context.h"
#include "common/transport/scene_link.h"
#include "device/pipeline/commands.h"

namespace meshloop {
namespace {

LinkOptions doctor_link() {
  LinkOptions link;
  link.scene = "doctor";
  return link;
}

Status check(const char* what, Status status, const std::string& when_good) {
  std::cout << fmt::format("{:<10} {}\n", what, status ? "good: " + when_good : "MISSING: " + status.error().message);
  return status;
}

Status doctor() {
  const auto gpu = GpuContext::create_headless();
  const Status graphics =
      check("graphics", gpu ? Status{} : Status{fail(gpu.error())}, gpu ? (*gpu)->description() : "");
  const auto reader = SceneReader::create(doctor_link());
  const Status network =
      check("network", reader ? Status{} : Status{fail(reader.error())}, "DDS starts on this machine");
  return graphics ? network : graphics;
}

}  // namespace

void add_doctor_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("doctor", "check graphics and network, with the remedy for what is missing");
  command->callback([&action] { action = doctor; });
}

}  // namespace meshloop
