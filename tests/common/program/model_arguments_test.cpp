#include "common/program/model_arguments.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "temporary_folder.h"

namespace meshloop {
namespace {

class ModelArgumentsTest : public testing::Test {
 protected:
  /// A triangle with sides of `size` along x and y.
  std::string triangle(const std::string& size) const {
    const auto file = (folder_ / "a.obj").string();
    std::ofstream{file} << "v 0 0 0\nv " << size << " 0 0\nv 0 " << size << " 0\nf 1 2 3\n";
    return file;
  }

  static ModelArguments parsed(const std::string& command_line) {
    ModelArguments arguments;
    CLI::App app;
    arguments.add_to(app, "--model");
    app.parse(command_line);
    return arguments;
  }

  TemporaryFolder folder_;
};

TEST_F(ModelArgumentsTest, TakesTheUnitOrTheScaleThatIsGiven) {
  const auto file = triangle("3200");
  for (const char* option : {"--unit mm", "--scale 0.001"}) {
    const auto imported = parsed("--model " + file + " " + option).import();
    ASSERT_TRUE(imported) << imported.error().message;
    EXPECT_NEAR(imported->size_m.x(), 3.2f, 1e-3f) << option;
    EXPECT_EQ(import_json(*imported)["unit"], "given") << option;
  }
  const auto refused = parsed("--model " + file).import();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("--unit mm"), std::string::npos) << refused.error().message;
}

TEST_F(ModelArgumentsTest, SaysWhatWasAssumed) {
  const auto file = triangle("2");
  const auto imported = parsed("--model " + file).import();
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(import_text(file, *imported), "a.obj: 2.00 x 2.00 x 0.00 m; metres are assumed, the file states no unit");
  const auto json = import_json(*imported);
  EXPECT_EQ(json["unit"], "assumed");
  EXPECT_EQ(json["unit_m"], 1.0);
}

TEST_F(ModelArgumentsTest, SaysSmallSizesWithThreeDigits) {
  ImportedModel model;
  model.size_m = {12.3456F, 0.054321F, 0.000123456F};
  EXPECT_THAT(import_text("a.ply", model), testing::StartsWith("a.ply: 12.35 x 0.0543 x 0.000123 m;"));
  model.size_m = {0.5F, 1e-9F, 0};
  EXPECT_THAT(import_text("a.ply", model), testing::StartsWith("a.ply: 0.500 x 0.00 x 0.00 m;"));
}

TEST_F(ModelArgumentsTest, RefusesUnitsThatAreNoneAndBothAtOnce) {
  for (const char* options : {"--unit parsec", "--scale 0", "--scale -1", "--scale nan", "--unit mm --scale 0.001"}) {
    EXPECT_THROW(parsed(std::string{"--model a.obj "} + options), CLI::ParseError) << options;
  }
}

}  // namespace
}  // namespace meshloop
