#include "common/base/log.h"

#include <gtest/gtest.h>
#include <stdlib.h>

namespace meshloop {
namespace {

class Log : public testing::Test {
 protected:
  void TearDown() override { ::unsetenv("MESHLOOP_LOG"); }

  static std::string all_levels() {
    testing::internal::CaptureStderr();
    log_info("a {}", 1);
    log_warning("b");
    log_error("{}", "c{}");
    return testing::internal::GetCapturedStderr();
  }
};

TEST_F(Log, WritesWarningsAndErrorsByDefault) {
  ::unsetenv("MESHLOOP_LOG");
  EXPECT_EQ(all_levels(), "meshloop: warning: b\nmeshloop: error: c{}\n");
}

TEST_F(Log, WritesWhatTheEnvironmentAsksFor) {
  ::setenv("MESHLOOP_LOG", "info", 1);
  EXPECT_EQ(all_levels(), "meshloop: info: a 1\nmeshloop: warning: b\nmeshloop: error: c{}\n");
  ::setenv("MESHLOOP_LOG", "error", 1);
  EXPECT_EQ(all_levels(), "meshloop: error: c{}\n");
}

TEST_F(Log, AnUnknownLevelMeansTheDefault) {
  ::setenv("MESHLOOP_LOG", "loud", 1);
  EXPECT_EQ(all_levels(), "meshloop: warning: b\nmeshloop: error: c{}\n");
}

}  // namespace
}  // namespace meshloop
