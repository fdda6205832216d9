#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/syntax.h"

namespace diaphane::dicom {

/// The tag of the pixel data.
inline constexpr std::uint32_t kPixelData = 0x7FE00010;

/// Limits on the memory that one file may request.
struct Limits {
  std::uint64_t file_bytes = std::uint64_t{1} << 30;
  std::uint64_t pixel_bytes = std::uint64_t{1}
                              << 30;  ///< rows x columns x frames x samples x bytes
  std::uint64_t frame_bytes = std::uint64_t{1} << 26;     ///< per image: 5792 x 5792
  std::uint64_t inflated_bytes = std::uint64_t{1} << 28;  ///< limit for a deflated data set
  std::uint64_t inflated_free = std::uint64_t{1} << 24;   ///< fixed part of its relative limit
  std::uint32_t inflated_ratio = 32;                      ///< added per byte of the deflated data
  std::uint32_t elements = 1000000;  ///< over all items; an enhanced file has about 50 per frame
  std::uint32_t frames = 20000;
  std::uint32_t nesting = 16;  ///< nested sequences
};

enum class FileState {
  kFit,          ///< GDCM may read it
  kNotDicom,     ///< not a DICOM file
  kDamaged,      ///< begins as DICOM, but is truncated or contradicts itself
  kTooLarge,     ///< exceeds the limits
  kUnsupported,  ///< a transfer syntax that is not supported
};

/// Position of a top-level element with its header, or of a value, in the file.
struct Range {
  std::uint32_t tag = 0;
  std::size_t begin = 0, end = 0;
};

/// A value from the functional groups of an enhanced file for a frame (DICOM PS3.3, C.7.6.16), as
/// in the file.
struct GroupedText {
  std::uint32_t tag = 0;
  std::string value;
};

struct Precheck {
  Precheck() = default;
  Precheck(Precheck&&) = default;
  Precheck& operator=(Precheck&&) = default;
  Precheck(const Precheck&) = delete;  // contains views into itself
  Precheck& operator=(const Precheck&) = delete;

  FileState state = FileState::kNotDicom;
  std::string text;  ///< reason for refusal, without any text from the file
  TransferSyntax syntax;
  std::uint16_t rows = 0;
  std::uint16_t columns = 0;
  std::uint64_t frames = 1;
  bool has_pixels = false;
  bool has_lookup_table = false;     ///< has a Modality LUT Sequence
  std::uint64_t unpacked_bytes = 0;  ///< size after unpacking; 0 if it is not compressed
  /// The bytes that GDCM reads instead of the file: the few elements that a volume depends on,
  /// inflated, behind a new header, without pixels. GDCM never sees overlays, comments, the
  /// preamble, or private and nested elements. A volume does not need them, and GDCM 3.0.21 aborts
  /// with a failed assertion on some that are malformed (see precheck_test).
  std::vector<std::byte> plain;
  std::vector<Range> elements;  ///< ranges in `plain`
  /// The bytes of the pixels. Native pixels are one span, compressed pixels are the fragments
  /// without the offset table. They point into the checked file or into `inflated`, so that a file
  /// of 1 GB is not held twice.
  std::vector<std::span<const std::byte>> pixels;
  bool encapsulated = false;
  /// For compressed images, the index of each frame's first fragment, followed by the number of
  /// fragments.
  std::vector<std::size_t> frame_fragments;
  std::vector<std::byte> inflated;  ///< contents of a deflated file

  bool has_groups = false;          ///< an enhanced file, which gives the position of each frame
  std::vector<GroupedText> shared;  ///< values of all frames
  std::vector<std::vector<GroupedText>> each;  ///< values per frame
};

/// A file whose header was read and whose data set was inflated, if necessary.
struct OpenedFile {
  OpenedFile() = default;
  OpenedFile(OpenedFile&&) = default;
  OpenedFile& operator=(OpenedFile&&) = default;
  OpenedFile(const OpenedFile&) = delete;  // contains a view into itself
  OpenedFile& operator=(const OpenedFile&) = delete;

  FileState state = FileState::kFit;
  std::string text;  ///< reason for refusal
  TransferSyntax syntax;
  std::span<const std::byte> data;   ///< the data set, in the file or in `inflated`
  std::vector<std::byte> inflated;   ///< contents of a deflated file
  std::uint64_t unpacked_bytes = 0;  ///< size of a deflated file, even if it is refused
};
/// Reads the header and inflates the data set, as the first part of precheck(). Does not check the
/// data set.
OpenedFile open_file(std::span<const std::byte> file, const Limits& limits);

/// Walks the whole file before any library reads it. It checks that every length is within the
/// remaining bytes, that sequences are not nested deeper than the limit, that the pixels are
/// complete and within the limits, that images inside compressed pixels have the size in the
/// header, and that the transfer syntax is supported. Pure. Reads only `file`, which must outlive
/// the result. Allocates memory beyond the file only for a deflated one, up to
/// `limits.inflated_bytes`. (Design: ingest, "Hostile input": a 286-byte file can make a reader
/// request 8.4 GB.)
Precheck precheck(std::span<const std::byte> file, const Limits& limits);

/// Returns one frame as a separate file: `Precheck::plain` and its pixels, with compressed pixels
/// as one fragment. Returns an empty file if the frame does not exist. Precondition: a fit file
/// with pixels.
std::vector<std::byte> frame_file(const Precheck& checked, std::uint64_t frame);

}  // namespace diaphane::dicom
