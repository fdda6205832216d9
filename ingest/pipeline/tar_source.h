#pragma once

#include <cstdint>

#include "ingest/dicom/source.h"

namespace diaphane::ingest {

/// The regular files of a tar archive behind an open file descriptor (docs/contracts.md, "Upload
/// bundle"). Ignores names, owners, times, and everything but regular files. Reads only the
/// beginning of files larger than `largest_file`. A visit returns kInvalid if the archive is broken
/// or truncated, or contains a sparse file.
class TarSource final : public dicom::FileSource {
 public:
  /// Borrows `fd`, which must be seekable.
  TarSource(int fd, std::uint64_t largest_file) : fd_(fd), largest_file_(largest_file) {}
  Result<void> visit(const Want& want, const Take& take) override;
  /// Returns whether the file could not be read, which says nothing about its contents.
  bool failed() const { return failed_; }

 private:
  int fd_;
  bool failed_ = false;
  std::uint64_t largest_file_;
};

}  // namespace diaphane::ingest
