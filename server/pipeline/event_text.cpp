#include "server/pipeline/event_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace meshloop {
namespace {

using Event = nlohmann::json;

std::string counted(const Event& count, std::string_view what) {
  const auto n = count.get<std::int64_t>();
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

/// What came from outside cannot drive the terminal.
std::string word(const Event& event, const char* key) {
  auto text = event.at(key).get<std::string>();
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }, '?');
  return text;
}

std::string serving_text(const Event& event) {
  return fmt::format("serving '{}', revision {}", word(event, "scene"), event.at("revision").get<int>());
}

std::string frame_text(const Event& event) {
  std::string text = fmt::format("frame {}: {}, tracked in {:.0f} ms", event.at("index").get<int>(),
                                 word(event, "state"), event.at("track_ms").get<double>());
  if (event.contains("confirmed_regions")) {
    text += "; " + counted(event.at("confirmed_regions"), "confirmed region");
  }
  if (event.contains("waits")) text += "; waits: " + word(event, "waits");
  return text;
}

std::string withheld_text(const Event& event) {
  return fmt::format("frame {}: withheld: {}", event.at("frame").get<int>(), word(event, "reason"));
}

std::string proposals_text(const Event& event) {
  return fmt::format("frame {}: {}", event.at("frame").get<int>(), counted(event.at("proposals").size(), "proposal"));
}

std::string revision_text(const Event& event) {
  const Event& frame = event.at("frame");
  std::string text = fmt::format("revision {}", event.at("revision").get<int>());
  if (!frame.is_null()) text += fmt::format(" from frame {}", frame.get<int>());
  text += ": " + word(event, "summary");
  if (!event.at("published").get<bool>()) return text + "; not published yet";
  return text + fmt::format("; {:.1f} kB to {}", event.at("bytes").get<double>() / 1000,
                            counted(event.at("devices"), "device"));
}

std::string command_text(const Event& event) {
  const Event& refused = event.at("refused");
  const std::string outcome = refused.is_null() ? "done" : "refused: " + word(event, "refused");
  return fmt::format("> {}: {}", word(event, "command"), outcome);
}

std::string end_text(const Event& event) {
  const Event& changes = event.at("changes");
  return fmt::format("end: revision {}; {} with confirmed changes: {} waited, {} looked at, {} withheld",
                     event.at("revision").get<int>(), counted(changes.at("confirmed"), "frame"),
                     changes.at("waiting").get<int>(), changes.at("looked_at").get<int>(),
                     changes.at("withheld").get<int>());
}

std::string commands_ended_text(const Event& /*event*/) {
  return "no more commands";
}

struct Kind {
  std::string_view event;
  std::string (*text)(const Event& event);
};

constexpr std::array kKinds{Kind{"serving", serving_text},
                            Kind{"frame", frame_text},
                            Kind{"withheld", withheld_text},
                            Kind{"proposals", proposals_text},
                            Kind{"revision", revision_text},
                            Kind{"command", command_text},
                            Kind{"commands_ended", commands_ended_text},
                            Kind{"end", end_text}};

}  // namespace

std::string event_text(const Event& event) {
  const auto name = word(event, "event");
  const auto kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& k) { return k.event == name; });
  return kind != kKinds.end() ? kind->text(event) : name;
}

}  // namespace meshloop
