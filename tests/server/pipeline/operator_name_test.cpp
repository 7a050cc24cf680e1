#include "server/pipeline/operator_name.h"

#include <gmock/gmock.h>

namespace meshloop {
namespace {

using testing::HasSubstr;

std::string wrong(const std::string& name) {
  return why_not_one_line(name, "a name", kLongestName);
}

TEST(OneLine, TakesLettersOfEveryLanguage) {
  for (const char* name : {"anna", "J\xc3\xb6rg M.", "\xe6\x9d\x8e\xe6\x98\x8e", "\xd0\x98\xd0\xb2\xd0\xb0\xd0\xbd",
                           "\xf0\x9f\x99\x82", "O'Neill (night shift)", "a"}) {
    EXPECT_EQ(wrong(name), "") << name;
  }
}

TEST(OneLine, RefusesBlanks) {
  for (const char* name : {"", " ", "   ", "\xc2\xa0", "\xe3\x80\x80", "\xe2\x80\x8b"}) {
    EXPECT_EQ(wrong(name), "a name needs more than blanks") << '[' << name << ']';
  }
  EXPECT_EQ(wrong(" anna"), "a name has no blanks at its ends");
  EXPECT_EQ(wrong("anna\xc2\xa0"), "a name has no blanks at its ends");
}

TEST(OneLine, RefusesWhatBreaksALineOrItsOrder) {
  for (const char* name : {"a\nb", "a\tb", "a\x1b[31mb", "a\x7f",
                           "\xc2\x85"
                           "a",
                           "a\xe2\x80\xa8"
                           "b",
                           "a\xe2\x80\xae"
                           "b",
                           "a\xe2\x81\xa6"
                           "b",
                           "\xef\xbb\xbf"
                           "a"}) {
    EXPECT_EQ(wrong(name), "a name has no control characters");
  }
  EXPECT_EQ(wrong(std::string{"a\0b", 3}), "a name has no control characters");
}

TEST(OneLine, RefusesBytesThatAreNoUtf8) {
  for (const char* name : {"J\xf6rg", "\xc3", "\xc0\xaf", "\xe2\x82", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                           "\xf0\x80\x80\xaf", "\x80", "\xff"}) {
    EXPECT_EQ(wrong(name), "a name must be UTF-8");
  }
}

TEST(OneLine, CountsLettersAndNotBytes) {
  std::string name;
  for (std::size_t i = 0; i < kLongestName; ++i) name += "\xc3\xb6";
  EXPECT_EQ(wrong(name), "");
  EXPECT_THAT(wrong(name + "a"), HasSubstr("at most 100 letters, not 101"));
  EXPECT_NE(wrong(std::string(1'000'000, 'a')), "");
}

}  // namespace
}  // namespace meshloop
