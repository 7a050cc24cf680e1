#pragma once

// GCC says it by macros, clang by features.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define MESHLOOP_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define MESHLOOP_SANITIZED
#endif

namespace meshloop::test {

/// True in builds with a sanitizer, where times mean nothing and large inputs take minutes.
#ifdef MESHLOOP_SANITIZED
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

}  // namespace meshloop::test

#undef MESHLOOP_SANITIZED
