// Any bytes as labels of a scan: NIfTI, DICOM segmentations and structure sets. Accepted labels fit
// the scan and survive the form in which they are stored.
#include "ingest/labels/read_labels.h"
#include "tests/fuzz/must.h"

using namespace diaphane;

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  volume::Header scan;
  scan.size = {6, 5, 4};
  scan.spacing = {1, 1.5, 2};
  scan.origin = {-3, -4, -5};
  ingest::LabelLimits limits;
  limits.unpacked_bytes = 1 << 20;
  limits.voxels = 1 << 18;
  limits.points = 10000;
  const auto set = ingest::read_labels(std::as_bytes(std::span(data, size)), scan, limits);
  if (!set) {
    MUST(!set.error().message.empty());
    return 0;
  }
  MUST(!set->empty() && set->table.size() <= volume::kMostLabels);
  MUST(set->labels.size == scan.size && set->labels.voxels.size() == scan.voxel_count());
  const auto again = volume::decode_label_set(volume::encode(*set), scan.size);
  MUST(again && again->table == set->table && again->labels.voxels == set->labels.voxels);
  return 0;
}
