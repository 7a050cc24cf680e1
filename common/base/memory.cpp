#include "common/base/memory.h"

#include <malloc.h>

namespace meshloop {

void keep_memory_between_frames() {
#ifdef __GLIBC__
  // A picture of 1280x720 with 8 bytes a pixel; larger blocks are not kept.
  constexpr int kLargestBlock_bytes = 8 << 20;
  constexpr int kKept_bytes = 32 << 20;
  mallopt(M_MMAP_THRESHOLD, kLargestBlock_bytes);
  mallopt(M_TRIM_THRESHOLD, kKept_bytes);
#endif
}

void give_memory_back() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace meshloop
