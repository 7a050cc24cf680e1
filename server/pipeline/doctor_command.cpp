// `doctor`: is all there that the station needs?
#include <fmt/format.h>

#include <iostream>

#include "common/gpu/context.h"
#include "common/transport/scene_link.h"
#include "server/compare/comparator.h"
#include "server/pipeline/commands.h"

namespace meshloop {
namespace {

LinkOptions doctor_link() {
  LinkOptions link;
  link.scene = "doctor";
  return link;
}

void say(const char* what, const Status& status, const std::string& when_good) {
  std::cout << fmt::format("{:<10} {}\n", what, status ? "good: " + when_good : "MISSING: " + status.error().message);
}

Status check_gpu() {
  const auto gpu = GpuContext::create_headless();
  Status status = gpu ? Status{} : Status{fail(gpu.error())};
  if (gpu) {
    if (const auto comparator = Comparator::create(**gpu); !comparator) status = fail(comparator.error());
  }
  say("graphics", status, gpu ? (*gpu)->description() : "");
  return status;
}

Status check_network() {
  const auto writer = SceneWriter::create(doctor_link());
  const Status status = writer ? Status{} : Status{fail(writer.error())};
  say("network", status, "DDS starts on this machine");
  return status;
}

Status doctor() {
  const Status gpu = check_gpu();
  const Status network = check_network();
  return gpu ? network : gpu;
}

}  // namespace

void add_doctor_command(CLI::App& app, Action& action) {
  CLI::App* command = app.add_subcommand("doctor", "check graphics and network, with the remedy for what is missing");
  command->callback([&action] { action = doctor; });
}

}  // namespace meshloop
