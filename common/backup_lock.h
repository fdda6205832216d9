#pragma once

#include <cstdint>

namespace diaphane {

/// The key of Postgres's advisory lock that a backup holds while it copies files whose rows it has
/// already saved (backup/diaphane_backup/database.py). Whoever deletes such files takes it shared,
/// without waiting, and otherwise leaves the deletion for later.
inline constexpr std::int64_t kBackupLock = 4711820932;

}  // namespace diaphane
