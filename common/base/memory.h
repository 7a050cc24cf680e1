#pragma once

namespace meshloop {

/// For programs that work frame by frame: each frame takes and frees pictures of a few megabytes. Left to itself the C
/// library gives the freed end of the heap back to the kernel, which clears its pages again for the next frame: a fifth
/// of the handheld's time. Afterwards up to 32 MB stay with the process.
void keep_memory_between_frames();

/// After a large piece of work that will not come again soon: what the C library keeps of it, from all threads, goes
/// back to the kernel. Some milliseconds.
void give_memory_back();

}  // namespace meshloop
