#include "common/transport/domain.h"

#include <gmock/gmock.h>

#include "link_fixture.h"

namespace meshloop {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

TEST(Domain, AlwaysAsksThisMachineAndThenThePeers) {
  const auto settings = domain_configuration({"10.0.0.5", "station.local:7410"}, "");
  ASSERT_TRUE(settings);
  EXPECT_THAT(*settings, HasSubstr(R"(<Peer Address="127.0.0.1"/><Peer Address="10.0.0.5"/>)"));
  EXPECT_THAT(*settings, HasSubstr(R"(<Peer Address="station.local:7410"/>)"));
}

TEST(Domain, TheUsersSettingsComeLastAndWin) {
  const auto settings = domain_configuration({}, "file:///etc/dds.xml");
  ASSERT_TRUE(settings);
  EXPECT_THAT(*settings, EndsWith("</CycloneDDS>,file:///etc/dds.xml"));
}

TEST(Domain, RefusesAPeerThatWouldBreakTheSettings) {
  for (const char* peer : {"", "\"/><Evil", "a b", "a,b"}) {
    const auto settings = domain_configuration({peer}, "");
    ASSERT_FALSE(settings) << peer;
    EXPECT_EQ(settings.error().kind, ErrorKind::usage);
  }
}

TEST(Domain, RefusesANumberWhosePortsDoNotExist) {
  const auto domain = Domain::join(kHighestDomain + 1, {});
  ASSERT_FALSE(domain);
  EXPECT_EQ(domain.error().kind, ErrorKind::usage);
}

TEST(Domain, IsSharedInTheProcessAndGoesWithTheLastUser) {
  const auto number = test::domain_of_process();
  auto first = Domain::join(number, {});
  ASSERT_TRUE(first) << first.error().message;
  auto second = Domain::join(number, {});
  ASSERT_TRUE(second) << second.error().message;
  first->reset();
  EXPECT_GT(dds_lookup_participant(number, nullptr, 0), 0);
  second->reset();
  EXPECT_EQ(dds_lookup_participant(number, nullptr, 0), 0);
  EXPECT_TRUE(Domain::join(number, {}));
}

TEST(Domain, SaysWhatToDoWhenTheUsersSettingsAreNoSettings) {
  ASSERT_EQ(setenv("CYCLONEDDS_URI", "<CycloneDDS><Domain><NoSuchThing/></Domain></CycloneDDS>", 1), 0);
  const auto domain = Domain::join(test::domain_of_process(), {});
  unsetenv("CYCLONEDDS_URI");
  ASSERT_FALSE(domain);
  EXPECT_THAT(domain.error().message, HasSubstr("CYCLONEDDS_URI"));
  EXPECT_TRUE(Domain::join(test::domain_of_process(), {}));
}

TEST(Domain, ThePeersOfTheEnvironmentAreCheckedToo) {
  ASSERT_EQ(setenv("MESHLOOP_PEERS", "10.0.0.5,not a host", 1), 0);
  const auto domain = Domain::join(test::domain_of_process(), {});
  unsetenv("MESHLOOP_PEERS");
  ASSERT_FALSE(domain);
  EXPECT_THAT(domain.error().message, HasSubstr("'not a host'"));
}

}  // namespace
}  // namespace meshloop
