#include "ingest/dicom/scan.h"

#include <algorithm>
#include <array>
#include <map>

#include "ingest/dicom/read_slice.h"

namespace diaphane::dicom {
namespace {

void count(const Precheck& checked, LeftOut& out) {
  switch (checked.state) {
    case FileState::kFit:
      return;
    case FileState::kNotDicom:
      ++out.not_dicom;
      return;
    case FileState::kDamaged:
      ++out.damaged;
      return;
    case FileState::kTooLarge:
      if (out.too_large++ == 0) out.too_large_text = checked.text;
      return;
    case FileState::kUnsupported:
      if (out.unsupported++ == 0) out.unsupported_text = checked.text;
      return;
  }
}

Choice refused(std::string code, std::string text) {
  Choice choice;
  choice.code = std::move(code);
  choice.text = std::move(text);
  return choice;
}

std::string sentence(std::string text) {
  if (!text.empty() && text[0] >= 'a' && text[0] <= 'z') text[0] = static_cast<char>(text[0] - 32);
  return text + ".";
}

Choice nothing_found(const Scan& scan) {
  const LeftOut& out = scan.left_out;
  if (scan.files == 0) return refused("empty", "It contains no files.");
  if (out.unsupported > 0)
    return refused("unsupported_compression", sentence(out.unsupported_text));
  if (out.too_large > 0) return refused("too_large", sentence(out.too_large_text));
  if (out.damaged > 0)
    return refused("damaged", "The files are damaged. Try copying the files from the disc again.");
  if (out.not_slices > 0) {
    return refused("no_slices",
                   "It contains only reports or screenshots, but no slices of a scan.");
  }
  return refused("not_dicom", "It contains no DICOM files.");
}

Choice take(const Scan& scan, std::size_t index) {
  Choice choice;
  choice.suitable = true;
  choice.index = index;
  choice.repairs = scan.series[index].assessment.repairs;
  const std::size_t lost =
      scan.left_out.damaged + scan.left_out.too_large + scan.left_out.unsupported;
  if (lost > 0) {
    choice.repairs.push_back(std::to_string(lost) + (lost == 1 ? " file was" : " files were") +
                             " damaged or unreadable and skipped");
  }
  return choice;
}

Choice refuse_largest(const Scan& scan) {
  if (scan.series.empty()) return nothing_found(scan);
  const auto largest = std::max_element(
      scan.series.begin(), scan.series.end(),
      [](const Series& a, const Series& b) { return a.slices.size() < b.slices.size(); });
  Choice choice = refused(largest->assessment.code, largest->assessment.text);
  const std::size_t damaged = scan.left_out.damaged;
  if (damaged > 0) {
    choice.text += damaged == 1 ? " One file is damaged."
                                : " " + std::to_string(damaged) + " files are damaged.";
  }
  return choice;
}

}  // namespace

Result<Scan> scan(FileSource& source, const ScanLimits& limits) {
  Scan result;
  std::map<std::array<std::string, 3>, std::size_t> known;  // keyed by series, patient and stack
  std::size_t taken = 0;
  std::uint64_t packed = 0, unpacked = 0;
  const auto look = [&](std::size_t index, FileSource::Bytes bytes) -> Result<void> {
    if (++result.files > limits.most_files) {
      return fail(ErrorCode::kTooLarge, "there are more files than allowed");
    }
    const Precheck checked = precheck(bytes, limits.file);
    if (checked.unpacked_bytes > 0) {
      unpacked += checked.unpacked_bytes;
      packed += bytes.size();
      if (unpacked >
          std::min(limits.unpacked_bytes, limits.unpacked_free + limits.unpacked_ratio * packed)) {
        return fail(ErrorCode::kTooLarge, "the decompressed files are larger than allowed");
      }
    }
    if (checked.state != FileState::kFit) {
      count(checked, result.left_out);
      return {};
    }
    auto slices = read_slices(checked);
    if (!slices) {
      ++result.left_out.damaged;
      return {};
    }
    if (slices->empty() || slices->front().kind == Kind::kOther || !slices->front().has_pixels) {
      ++result.left_out.not_slices;
      return {};
    }
    if ((taken += slices->size()) > limits.most_files) {
      return fail(ErrorCode::kTooLarge, "there are more slices than allowed");
    }
    for (Slice& slice : *slices) {
      slice.file = index;
      const auto [found, is_new] = known.emplace(
          std::array{slice.series_uid, slice.patient, slice.stack}, result.series.size());
      if (is_new) result.series.emplace_back();
      result.series[found->second].slices.push_back(std::move(slice));
    }
    return {};
  };
  if (auto ok = source.visit([](std::size_t) { return true; }, look); !ok) {
    return tl::unexpected(ok.error());
  }
  for (Series& series : result.series) {
    series.assessment = classify(series.slices, limits.most_voxels);
  }
  return result;
}

Choice choose(const Scan& scan) {
  const auto suitable = [](const Series& series) { return series.assessment.suitable; };
  const auto n = std::count_if(scan.series.begin(), scan.series.end(), suitable);
  if (n > 1) {
    return refused("several_series",
                   "It contains " + std::to_string(n) + " series. Upload one at a time.");
  }
  if (n == 0) return refuse_largest(scan);
  const auto found = std::find_if(scan.series.begin(), scan.series.end(), suitable);
  return take(scan, static_cast<std::size_t>(found - scan.series.begin()));
}

Choice choose_largest(const Scan& scan) {
  std::size_t best = scan.series.size();
  for (std::size_t i = 0; i < scan.series.size(); ++i) {
    const Assessment& a = scan.series[i].assessment;
    if (a.suitable && (best == scan.series.size() ||
                       a.order.size() > scan.series[best].assessment.order.size())) {
      best = i;
    }
  }
  return best == scan.series.size() ? refuse_largest(scan) : take(scan, best);
}

}  // namespace diaphane::dicom
