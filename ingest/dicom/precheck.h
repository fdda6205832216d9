#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ingest/dicom/syntax.h"

namespace diaphane::dicom {

/// What one file may ask for.
struct Limits {
  std::uint64_t file_bytes = std::uint64_t{1} << 30;
  std::uint64_t pixel_bytes = std::uint64_t{1}
                              << 30;  ///< rows x columns x frames x samples x bytes
  std::uint64_t frame_bytes = std::uint64_t{1} << 26;     ///< of one picture: 5792 x 5792
  std::uint64_t inflated_bytes = std::uint64_t{1} << 28;  ///< of a deflated data set,
  std::uint64_t inflated_free = std::uint64_t{1} << 24;   ///< and no more than this and so many
  std::uint32_t inflated_ratio = 32;                      ///< times its length
  std::uint32_t elements =
      1000000;  ///< in all items together; an enhanced file has some 50 a frame
  std::uint32_t frames = 20000;
  std::uint32_t nesting = 16;  ///< sequences within sequences
};

enum class FileState {
  kFit,          ///< GDCM may see it
  kNotDicom,     ///< some other file
  kDamaged,      ///< begins as DICOM, but ends too early or contradicts itself
  kTooLarge,     ///< asks for more than the limits allow
  kUnsupported,  ///< a transfer syntax that is not read
};

/// An element of the top level with its header, or a value, by where it stands.
struct Range {
  std::uint32_t tag = 0;
  std::size_t begin = 0, end = 0;
};

/// What the functional groups of an enhanced file say of a frame (DICOM PS3.3, C.7.6.16): values as
/// they stand.
struct GroupedText {
  std::uint32_t tag = 0;
  std::string value;
};

struct Precheck {
  Precheck() = default;
  Precheck(Precheck&&) = default;
  Precheck& operator=(Precheck&&) = default;
  Precheck(const Precheck&) = delete;  // views into itself
  Precheck& operator=(const Precheck&) = delete;

  FileState state = FileState::kNotDicom;
  std::string text;  ///< why not, in words; nothing of the file's own texts
  TransferSyntax syntax;
  std::uint16_t rows = 0;
  std::uint16_t columns = 0;
  std::uint64_t frames = 1;
  bool has_pixels = false;
  bool has_lookup_table = false;     ///< a Modality LUT Sequence is there
  std::uint64_t unpacked_bytes = 0;  ///< that a compressed file becomes; 0: it is not compressed
  /// What GDCM is given instead of the file: the few elements that a volume depends on, inflated,
  /// behind a header of our own, without the pixels. Overlays, private and nested elements,
  /// comments and the preamble never get to it: nobody needs them, and over some that are broken it
  /// ends the process (failed assertions in 3.0.21, found by precheck_test).
  std::vector<std::byte> plain;
  std::vector<Range> elements;  ///< of `plain`
  /// The bytes of the pixels: of native ones all in one, of compressed ones the fragments without
  /// the offset table. They stand in the file that was checked, or in `inflated`: a file of 1 GB is
  /// not to be held twice.
  std::vector<std::span<const std::byte>> pixels;
  bool encapsulated = false;
  /// Of compressed pixels the number of the first fragment of each frame, and that of fragments.
  std::vector<std::size_t> frame_fragments;
  std::vector<std::byte> inflated;  ///< what a deflated file became

  bool has_groups = false;          ///< an enhanced file, which says of each frame where it lies
  std::vector<GroupedText> shared;  ///< of all frames
  std::vector<std::vector<GroupedText>> each;  ///< of each frame
};

/// Walks the whole file before any library sees it: every length within the bytes that remain,
/// sequences no deeper than the limit, pixels within the quota and all there, pictures inside
/// compressed pixels of the size that the header says, a transfer syntax that is on the list. Pure;
/// reads nothing but `file`, which has to stay where it is for as long as the result is used;
/// memory beyond the file only for a deflated one, up to `limits.inflated_bytes`. (Design: ingest,
/// "Hostile input": a 286-byte file can make a reader ask for 8.4 GB.)
Precheck precheck(std::span<const std::byte> file, const Limits& limits);

/// One frame as a file of its own: `Precheck::plain` and its pixels, compressed ones as one
/// fragment. Empty when there is no such frame. Precondition: a fit file with pixels.
std::vector<std::byte> frame_file(const Precheck& checked, std::uint64_t frame);

}  // namespace diaphane::dicom
