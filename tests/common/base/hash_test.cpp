#include "common/base/hash.h"

#include <gtest/gtest.h>

#include <string_view>

namespace meshloop {
namespace {

std::string hash_text(std::string_view text) {
  return to_hex(hash_of(std::as_bytes(std::span{text})));
}

// Made with Python's hashlib.blake2b(..., digest_size=32).
TEST(Hash, IsBlake2bOf256Bits) {
  EXPECT_EQ(hash_text("abc"), "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319");
  EXPECT_EQ(hash_text(""), "0e5751c026e543b2e8ab2eb06099daa1d1e5df47778f7787faab45cdf12fe3a8");
}

TEST(Hash, ChangesWithEachByte) {
  EXPECT_NE(hash_text("abc"), hash_text("abd"));
  EXPECT_NE(hash_text("abc"), hash_text(std::string_view{"abc\0", 4}));
}

}  // namespace
}  // namespace meshloop
