#include "server/pipeline/options.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace meshloop {
namespace {

TEST(OperatorArguments, AreTheLoginNameUnlessTheyAreGiven) {
  ::setenv("USER", "anna", 1);
  EXPECT_EQ(OperatorArguments{}.name, "anna");
  for (const char* none : {"", static_cast<const char*>(nullptr)}) {
    none == nullptr ? ::unsetenv("USER") : ::setenv("USER", none, 1);
    EXPECT_NE(OperatorArguments{}.name, "") << "services and containers may have no USER";
  }
  OperatorArguments given;
  CLI::App app;
  given.add_to(app);
  app.parse("--operator bert");
  EXPECT_EQ(given.name, "bert");
}

TEST(OperatorArguments, RefuseNamesThatWouldBreakALine) {
  OperatorArguments arguments;
  CLI::App app;
  arguments.add_to(app);
  EXPECT_THROW(app.parse(std::vector<std::string>{"a\nb", "--operator"}), CLI::ValidationError);
  EXPECT_NO_THROW(app.parse(std::vector<std::string>{"J\xc3\xb6rg M.", "--operator"}));
}

TEST(SurfaceArguments, TexturesAreOnOrOff) {
  SurfaceArguments arguments;
  CLI::App app;
  arguments.add_to(app);
  EXPECT_FALSE(arguments.adjust_options().texture);
  app.parse("--texture on");
  EXPECT_TRUE(arguments.adjust_options().texture);
  app.parse("--texture off");
  EXPECT_FALSE(arguments.adjust_options().texture);
  EXPECT_THROW(app.parse("--texture maybe"), CLI::ValidationError);
}

}  // namespace
}  // namespace meshloop
