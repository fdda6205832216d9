#pragma once

namespace diaphane::service {

/// From here on memory is overwritten when it is freed, by whichever library, and large pieces go
/// back to the system at once. Voxels and parts of uploads are therefore gone from this process as
/// soon as nobody uses them. Call it first in main(). Pieces of at most 1032 bytes may keep their
/// contents until they are used again, because the C library caches them before it overwrites.
/// Without effect under a sanitizer, which brings its own allocator.
void overwrite_freed_memory();

}  // namespace diaphane::service
