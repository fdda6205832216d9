#pragma once

#include <cstdint>

#include "ingest/dicom/source.h"

namespace diaphane::ingest {

/// The regular files of a tar archive behind an open file descriptor (docs/contracts.md, "Upload
/// bundle"). Names, owners and times in it are not looked at; anything but regular files is passed
/// over. Of files larger than `largest_file` only the beginning is read. kInvalid when the archive
/// is broken or cut off, or has a file with holes (sparse).
class TarSource final : public dicom::FileSource {
 public:
  /// `fd` stays the caller's and must allow seeking.
  TarSource(int fd, std::uint64_t largest_file) : fd_(fd), largest_file_(largest_file) {}
  Result<void> visit(const Want& want, const Take& take) override;

 private:
  int fd_;
  std::uint64_t largest_file_;
};

}  // namespace diaphane::ingest
