#include "server/pipeline/event_text.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

TEST(EventText, IsALineForPeople) {
  EXPECT_EQ(event_text({{"event", "serving"}, {"scene", "room"}, {"revision", 3}}), "serving 'room', revision 3");
  EXPECT_EQ(event_text({{"event", "commands_ended"}}), "no more commands");
  EXPECT_EQ(event_text({{"event", "another"}}), "another");
  EXPECT_EQ(event_text({{"event", "withheld"}, {"frame", 4}, {"reason", "the pose is lost"}}),
            "frame 4: withheld: the pose is lost");
  EXPECT_EQ(event_text({{"event", "proposals"}, {"frame", 4}, {"proposals", {nullptr}}}), "frame 4: 1 proposal");
}

TEST(EventText, OfAFrameSaysWhatIsKnown) {
  nlohmann::json frame{{"event", "frame"}, {"index", 7}, {"state", "lost"}, {"track_ms", 33.34}, {"timestamp", 1.7}};
  EXPECT_EQ(event_text(frame), "frame 7: lost, tracked in 33 ms");
  frame["state"] = "tracking";
  frame["confirmed_regions"] = 1;
  EXPECT_EQ(event_text(frame), "frame 7: tracking, tracked in 33 ms; 1 confirmed region");
  frame["waits"] = "the camera moves too fast";
  EXPECT_EQ(event_text(frame),
            "frame 7: tracking, tracked in 33 ms; 1 confirmed region; waits: the camera moves too fast");
}

TEST(EventText, OfARevisionSaysWhatWasSentToHowMany) {
  nlohmann::json revision{
      {"event", "revision"}, {"revision", 2},  {"frame", 5},  {"summary", "proposal 1: +9 triangles"},
      {"published", true},   {"bytes", 39287}, {"devices", 1}};
  EXPECT_EQ(event_text(revision), "revision 2 from frame 5: proposal 1: +9 triangles; 39.3 kB to 1 device");
  revision["published"] = false;
  EXPECT_EQ(event_text(revision), "revision 2 from frame 5: proposal 1: +9 triangles; not published yet");
  revision["frame"] = nullptr;
  EXPECT_EQ(event_text(revision), "revision 2: proposal 1: +9 triangles; not published yet");
}

TEST(EventText, OfACommandSaysWhetherItWasRefused) {
  nlohmann::json command{{"event", "command"}, {"command", "undo"}, {"refused", nullptr}, {"revision", 2}};
  EXPECT_EQ(event_text(command), "> undo: done");
  command["refused"] = "nothing is proposed now";
  EXPECT_EQ(event_text(command), "> undo: refused: nothing is proposed now");
}

TEST(EventText, CannotDriveTheTerminal) {
  const nlohmann::json command{{"event", "command"}, {"command", "\x1b[31m\xff"}, {"refused", "\a"}, {"revision", 2}};
  EXPECT_EQ(event_text(command), "> ?[31m?: refused: ?");
}

TEST(EventText, OfTheEndHasTheFigures) {
  const nlohmann::json changes{
      {"confirmed", 6}, {"waiting", 1}, {"looked_at", 4}, {"withheld", 3}, {"reason", nullptr}};
  EXPECT_EQ(event_text({{"event", "end"}, {"revision", 2}, {"changes", changes}}),
            "end: revision 2; 6 frames with confirmed changes: 1 waited, 4 looked at, 3 withheld");
}

}  // namespace
}  // namespace meshloop
