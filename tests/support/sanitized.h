#pragma once

namespace meshloop::test {

/// True in builds with a sanitizer, where times mean nothing and large inputs take minutes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace meshloop::test
