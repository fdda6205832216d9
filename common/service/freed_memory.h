#pragma once

namespace diaphane::service {

/// Makes the allocator overwrite freed memory, for all libraries, and return large blocks to the
/// system immediately. Voxels and parts of uploads thus disappear from this process as soon as they
/// are no longer used. Call it first in main(). Blocks of at most 1032 bytes may keep their
/// contents until they are reused, because the C library caches them before it overwrites them. Has
/// no effect under a sanitizer, which brings its own allocator.
void overwrite_freed_memory();

}  // namespace diaphane::service
