#include "ingest/export/nifti_writer.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "common/try.h"
#include "ingest/export/placement.h"
#include "volume/alignment.h"
#include "volume/header.h"

namespace diaphane::ingest {
namespace {

static_assert(std::endian::native == std::endian::little, "voxels are written as they are stored");

constexpr std::size_t kVoxelsBegin = 352;  // header and an empty extension field

class HeaderBytes {
 public:
  template <typename T>
  void put(std::size_t offset, T value) {
    std::memcpy(bytes_.data() + offset, &value, sizeof value);
  }
  void put_text(std::size_t offset, std::string_view text) {
    std::copy(text.begin(), text.end(), bytes_.data() + offset);
  }
  std::string_view view() const { return {bytes_.data(), bytes_.size()}; }

 private:
  std::array<char, kVoxelsBegin> bytes_{};
};

/// Returns the unit quaternion (a, b, c, d) with a >= 0 of a rotation (row-major).
std::array<double, 4> quaternion_of(const std::array<double, 9>& r) {
  // The largest component is computed first, because the others are divided by it.
  const std::array<double, 4> squared{1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8],
                                      1 - r[0] + r[4] - r[8], 1 - r[0] - r[4] + r[8]};
  const auto largest = std::max_element(squared.begin(), squared.end()) - squared.begin();
  const double part = std::sqrt(squared[static_cast<std::size_t>(largest)]) / 2;
  const double by = 1 / (4 * part);
  std::array<double, 4> q{};
  if (largest == 0) {
    q = {part, (r[7] - r[5]) * by, (r[2] - r[6]) * by, (r[3] - r[1]) * by};
  } else if (largest == 1) {
    q = {(r[7] - r[5]) * by, part, (r[1] + r[3]) * by, (r[2] + r[6]) * by};
  } else if (largest == 2) {
    q = {(r[2] - r[6]) * by, (r[1] + r[3]) * by, part, (r[5] + r[7]) * by};
  } else {
    q = {(r[3] - r[1]) * by, (r[2] + r[6]) * by, (r[5] + r[7]) * by, part};
  }
  if (q[0] < 0) {
    for (double& one : q) one = -one;
  }
  return q;
}

/// Places the voxels by both forms. The offsets are those of nifti1.h.
void put_placement(const volume::Header& header, HeaderBytes& out) {
  constexpr std::size_t kQformCode = 252, kSformCode = 254, kQuatern = 256, kQoffset = 268,
                        kSrow = 280;
  constexpr std::int16_t kScanner = 1, kAligned = 2;
  const std::int16_t code = header.origin ? kScanner : kAligned;
  out.put<std::int16_t>(kQformCode, code);
  out.put<std::int16_t>(kSformCode, code);
  const auto first = volume::first_voxel(header);
  std::array<double, 9> ras =
      header.direction;  // NIfTI's x and y axes are opposite to those of LPS
  for (std::size_t i = 0; i < 6; ++i) ras[i] = -ras[i];
  const auto q = quaternion_of(ras);
  for (std::size_t row = 0; row < 3; ++row) {
    const double at = row < 2 ? -first[row] : first[row];
    out.put(kQuatern + 4 * row, static_cast<float>(q[row + 1]));
    out.put(kQoffset + 4 * row, static_cast<float>(at));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      out.put(kSrow + 16 * row + 4 * axis,
              static_cast<float>(ras[3 * row + axis] * header.spacing[axis]));
    }
    out.put(kSrow + 16 * row + 12, static_cast<float>(at));
  }
}

/// The fourth axis of a scan with phases.
struct TimeAxis {
  float step = 1;
  std::uint8_t unit = 0;  ///< 0: unknown
};

/// NIfTI only has even steps of time. Phases of other kinds get the step 1 without a unit.
TimeAxis time_axis_of(const volume::Header& header) {
  constexpr std::uint8_t kMilliseconds = 16;
  constexpr double kNegligible = 0.01;  // of a step
  const auto& phases = header.phases;
  if (phases.empty() || phases.front().kind != volume::PhaseKind::kTime) return {};
  const double step =
      (phases.back().value - phases.front().value) / static_cast<double>(phases.size() - 1);
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const double even = phases.front().value + static_cast<double>(i) * step;
    if (!(step > 0) || std::abs(phases[i].value - even) > kNegligible * step) return {};
  }
  return {static_cast<float>(step), kMilliseconds};
}

HeaderBytes header_of(const volume::Header& header) {
  constexpr std::size_t kDim = 40, kDataType = 70, kBitPix = 72, kPixDim = 76, kVoxOffset = 108,
                        kSlope = 112, kUnits = 123, kCalMax = 124, kCalMin = 128, kIntentName = 328,
                        kMagic = 344;
  HeaderBytes out;
  out.put<std::int32_t>(0, 348);
  const TimeAxis time = time_axis_of(header);
  out.put<std::int16_t>(kDim, header.phases.empty() ? 3 : 4);
  // The determinant of the axes is positive, so the factor of the third one (pixdim[0]) is 1.
  out.put<float>(kPixDim, 1);
  for (std::size_t i = 0; i < 7; ++i) {
    const bool spatial = i < 3;
    out.put(kDim + 2 * (i + 1), static_cast<std::int16_t>(spatial ? header.size[i] : 1));
    out.put(kPixDim + 4 * (i + 1), spatial ? static_cast<float>(header.spacing[i]) : 0.0F);
  }
  if (!header.phases.empty()) {
    out.put(kDim + 8, static_cast<std::int16_t>(header.phases.size()));
    out.put(kPixDim + 16, time.step);
  }
  constexpr std::int16_t kInt16 = 4;
  constexpr std::uint8_t kMillimetres = 2;
  out.put<std::int16_t>(kDataType, kInt16);
  out.put<std::int16_t>(kBitPix, 16);
  out.put<float>(kVoxOffset, kVoxelsBegin);
  out.put<float>(kSlope, 1);
  out.put<std::uint8_t>(kUnits, kMillimetres | time.unit);
  if (header.window_width > 0) {
    const double half = header.window_width / 2;
    out.put(kCalMax, static_cast<float>(header.window_center + half));
    out.put(kCalMin, static_cast<float>(header.window_center - half));
  }
  put_placement(header, out);
  if (header.modality != volume::Modality::kOther)
    out.put_text(kIntentName, volume::name_of(header.modality));
  out.put_text(kMagic, "n+1");
  return out;
}

/// Compresses with gzip's format.
class Gzip {
 public:
  explicit Gzip(const Sink& sink) : sink_(sink), buffer_(1 << 18) {
    constexpr int kGzip = 15 + 16, kMemory = 8;
    ready_ = deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kGzip, kMemory,
                          Z_DEFAULT_STRATEGY) == Z_OK;
  }
  ~Gzip() { deflateEnd(&stream_); }
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

  Result<void> add(std::string_view bytes, bool last) {
    if (!ready_) return fail(ErrorCode::kOutOfMemory, "not enough memory for compression");
    // The number of available bytes has 32 bits, so a volume is compressed in pieces.
    constexpr std::size_t kPiece = std::size_t{1} << 30;
    do {
      const std::string_view piece = bytes.substr(0, kPiece);
      bytes.remove_prefix(piece.size());
      // zlib reads the input only.
      stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
      stream_.avail_in = static_cast<uInt>(piece.size());
      DIAPHANE_TRY(drain(last && bytes.empty() ? Z_FINISH : Z_NO_FLUSH));
    } while (!bytes.empty());
    return {};
  }

 private:
  Result<void> drain(int flush) {
    do {
      stream_.next_out = buffer_.data();
      stream_.avail_out = static_cast<uInt>(buffer_.size());
      (void)deflate(&stream_, flush);  // cannot fail: there is room in the buffer
      DIAPHANE_TRY(sink_(
          {reinterpret_cast<const char*>(buffer_.data()), buffer_.size() - stream_.avail_out}));
    } while (stream_.avail_out == 0);
    return {};
  }

  const Sink& sink_;
  std::vector<Bytef> buffer_;
  z_stream stream_{};
  bool ready_ = false;
};

}  // namespace

Result<void> write_nifti(const volume::Header& header, std::span<const std::int16_t> voxels,
                         bool compress, const Sink& sink) {
  if (*std::max_element(header.size.begin(), header.size.end()) > kMostNiftiSide) {
    return fail(ErrorCode::kTooLarge, "NIfTI allows at most 32,767 voxels along an axis");
  }
  const HeaderBytes head = header_of(header);
  const std::string_view body(reinterpret_cast<const char*>(voxels.data()), voxels.size_bytes());
  if (compress) {
    Gzip gzip(sink);
    DIAPHANE_TRY(gzip.add(head.view(), false));
    return gzip.add(body, true);
  }
  DIAPHANE_TRY(sink(head.view()));
  return sink(body);
}

}  // namespace diaphane::ingest
