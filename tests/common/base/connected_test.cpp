#include "common/base/connected.h"

#include <gtest/gtest.h>

namespace meshloop {
namespace {

TEST(Connected, TheFirstStandsForAll) {
  Connected connected{6};
  connected.join(4, 2);
  connected.join(5, 4);
  connected.join(0, 1);
  for (const std::uint32_t thing : {2U, 4U, 5U}) EXPECT_EQ(connected.first_of(thing), 2U);
  EXPECT_EQ(connected.first_of(1), 0U);
  EXPECT_EQ(connected.first_of(3), 3U);
  connected.join(5, 1);
  EXPECT_EQ(connected.first_of(4), 0U);
}

}  // namespace
}  // namespace meshloop
