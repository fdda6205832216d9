#include "ingest/labels/read_labels.h"

#include <zlib.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <new>

#include "common/try.h"
#include "ingest/build/nifti.h"
#include "ingest/dicom/data_set.h"

namespace diaphane::ingest {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::uint32_t kSopClass = 0x00080016;

bool is_gzip(Bytes file) {
  return file.size() > 2 && file[0] == std::byte{0x1f} && file[1] == std::byte{0x8b};
}

Result<std::vector<std::byte>> unpack(Bytes file, std::uint64_t most) {
  z_stream stream{};
  constexpr int kGzip = 16;
  if (inflateInit2(&stream, kGzip + MAX_WBITS) != Z_OK) {
    return fail(ErrorCode::kOutOfMemory, "The labels need more memory than allowed.");
  }
  std::vector<std::byte> unpacked;
  std::vector<std::byte> part(std::size_t{1} << 18);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(file.data()));
  stream.avail_in = static_cast<uInt>(file.size());
  int code = Z_OK;
  while (code == Z_OK && unpacked.size() <= most) {
    stream.next_out = reinterpret_cast<Bytef*>(part.data());
    stream.avail_out = static_cast<uInt>(part.size());
    code = inflate(&stream, Z_NO_FLUSH);
    unpacked.insert(unpacked.end(), part.begin(),
                    part.end() - static_cast<std::ptrdiff_t>(stream.avail_out));
  }
  inflateEnd(&stream);
  if (unpacked.size() > most) {
    return fail(ErrorCode::kTooLarge, "The unpacked label file is larger than allowed.");
  }
  if (code != Z_STREAM_END) return fail(ErrorCode::kInvalid, "The label file is damaged.");
  return unpacked;
}

Error refusal_of(dicom::FileState state, const std::string& text) {
  switch (state) {
    case dicom::FileState::kTooLarge:
      return {ErrorCode::kTooLarge, "The label file is not accepted: " + text + ".", {}};
    case dicom::FileState::kUnsupported:
      return {ErrorCode::kUnsupported, "The label file is not accepted: " + text + ".", {}};
    case dicom::FileState::kNotDicom:
      return {ErrorCode::kUnsupported,
              "This is not a file of labels. Labels can be a NIfTI label volume, a DICOM "
              "segmentation or a DICOM structure set.",
              {}};
    default:
      return {ErrorCode::kInvalid, "The label file is damaged: " + text + ".", {}};
  }
}

Result<volume::LabelSet> read_dicom_labels(Bytes file, const volume::Header& scan,
                                           const LabelLimits& limits) {
  dicom::Limits dicom_limits;
  dicom_limits.file_bytes = limits.file_bytes;
  // A segmentation has about 30 elements per frame, and one frame per slice and segment.
  dicom_limits.elements = 3'000'000;
  const dicom::OpenedFile opened = dicom::open_file(file, dicom_limits);
  if (opened.state != dicom::FileState::kFit) {
    return tl::unexpected(refusal_of(opened.state, opened.text));
  }
  if (opened.syntax.big_endian) {
    return fail(ErrorCode::kUnsupported, "Labels in big-endian DICOM files are not supported.");
  }
  dicom::DataSet elements;
  const dicom::Walked walked =
      dicom::walk(opened.data, opened.syntax.explicit_vr, false, dicom_limits, &elements);
  if (walked.state != dicom::FileState::kFit) {
    return tl::unexpected(refusal_of(walked.state, walked.text));
  }
  const std::string sop_class = dicom::text_of(elements, kSopClass);
  if (sop_class == "1.2.840.10008.5.1.4.1.1.481.3") {
    return read_structure_set(elements, scan, limits);
  }
  if (sop_class != "1.2.840.10008.5.1.4.1.1.66.4") {
    return fail(ErrorCode::kUnsupported,
                "This DICOM file is neither a segmentation (SEG) nor a structure set (RTSTRUCT).");
  }
  if (walked.encapsulated) {
    return fail(ErrorCode::kUnsupported, "Compressed DICOM segmentations are not supported.");
  }
  auto image = read_segmentation(elements, limits);
  DIAPHANE_TRY(image);
  return place_labels(*std::move(image), scan);
}

}  // namespace

Result<volume::LabelSet> read_labels(Bytes file, const volume::Header& scan,
                                     const LabelLimits& limits) {
  if (file.size() > limits.file_bytes) {
    return fail(ErrorCode::kTooLarge, "The label file is larger than allowed.");
  }
  try {
    std::vector<std::byte> unpacked;
    if (is_gzip(file)) {
      auto done = unpack(file, limits.unpacked_bytes);
      DIAPHANE_TRY(done);
      unpacked = *std::move(done);
      file = unpacked;
    }
    if (!is_nifti(file)) return read_dicom_labels(file, scan, limits);
    auto image = read_nifti_labels(file, limits);
    DIAPHANE_TRY(image);
    return place_labels(*std::move(image), scan);
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::kOutOfMemory, "The labels need more memory than allowed.");
  }
}

Result<volume::LabelSet> read_label_file(const std::string& path, const volume::Header& scan,
                                         const LabelLimits& limits) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) return fail(ErrorCode::kNotFound, "cannot read " + path);
  if (size > limits.file_bytes) {
    return fail(ErrorCode::kTooLarge, "The label file is larger than allowed.");
  }
  std::vector<std::byte> bytes(size);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return read_labels(bytes, scan, limits);
}

}  // namespace diaphane::ingest
