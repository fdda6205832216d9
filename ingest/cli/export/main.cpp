#include <charconv>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/try.h"
#include "ingest/body/label_body.h"
#include "ingest/build/read_scan.h"
#include "ingest/export/export_scan.h"
#include "ingest/labels/read_labels.h"
#include "volume/labels.h"
#include "volume/volume.h"

namespace {

using namespace diaphane;
namespace fs = std::filesystem;

constexpr int kExitData = 65;      // sysexits.h: EX_DATAERR, the input cannot be exported this way
constexpr int kExitNoInput = 66;   // EX_NOINPUT, the input is unreadable
constexpr int kExitNoOutput = 73;  // EX_CANTCREAT, the output cannot be written

constexpr const char* kUsage =
    "diaphane-export INPUT OUTPUT [--label LABEL | --above VALUE] [--labels FILE]\n"
    "                [--phase N] [--triangles N] [--force]\n\n"
    "Writes a scan as NIfTI, or the surface of one of its parts as STL or glTF. INPUT is a stored\n"
    "volume, a folder of DICOM files, or a file in a research format (NIfTI, NRRD, MetaImage).\n\n"
    "  OUTPUT           .nii or .nii.gz: all voxels of all phases, with the values as stored "
    "(Hounsfield units\n"
    "                   for CT), in millimetres, RAS\n"
    "                   .stl: a surface in millimetres, LPS (z points to the head)\n"
    "                   .glb: a surface in metres, with the head up and the face to the viewer\n"
    "  --label LABEL    surface of a label, by its name or number. Parts that are found in the "
    "scan are\n"
    "                   called brain, bone, lungs, airways and vessels\n"
    "  --above VALUE    surface of all voxels with at least this value\n"
    "  --phase N        phase of the surface of --above, counted from 0 (default 0)\n"
    "  --labels FILE    take the labels from a NIfTI, DICOM SEG or RTSTRUCT file\n"
    "  --triangles N    maximum number of triangles (default 1000000)\n"
    "  --force          replace OUTPUT, and OUTPUT.part of an export that was interrupted\n\n"
    "The file may identify a person: a surface of the skin shows the face.\n\n"
    "Exit codes: 0 success, 64 bad command line, 65 the scan has no such label or value, 66 "
    "cannot\n"
    "read the input, 73 cannot write the output.\n";

struct Options {
  std::string input, output, label, label_file;
  std::optional<std::int32_t> above;
  std::optional<std::uint32_t> phase;
  ingest::SurfaceLimits limits;
  bool force = false;
};

int complain(int exit_code, const std::string& text) {
  std::fprintf(stderr, "diaphane-export: %s\n", text.c_str());
  return exit_code;
}

template <typename T>
bool parse(const std::string& text, T& value) {
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && stop == text.data() + text.size();
}

/// Reads an option with a value. Returns what is wrong, or an empty string.
std::string take_option(const std::string& name, const std::string& value, Options& options) {
  if (name == "--label") {
    options.label = value;
  } else if (name == "--labels") {
    options.label_file = value;
  } else if (name == "--above") {
    std::int32_t above = 0;
    if (!parse(value, above)) return "--above: must be a whole number (see --help)";
    options.above = above;
  } else if (name == "--phase") {
    std::uint32_t phase = 0;
    if (!parse(value, phase)) return "--phase: must be a whole number (see --help)";
    options.phase = phase;
  } else if (name == "--triangles") {
    constexpr std::uint64_t kFewest = 100, kMost = 50'000'000;
    if (!parse(value, options.limits.triangles) || options.limits.triangles < kFewest ||
        options.limits.triangles > kMost) {
      return "--triangles: must be between 100 and 50000000 (see --help)";
    }
    options.limits.raw_triangles = std::max(options.limits.raw_triangles, options.limits.triangles);
  } else {
    return "unknown option " + name + " (see --help)";
  }
  return {};
}

std::string read_options(const std::vector<std::string>& words, Options& options) {
  std::vector<std::string> positional;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    if (word == "--force") {
      options.force = true;
    } else if (word.starts_with("--")) {
      const bool has_value = i + 1 < words.size();
      std::string wrong = take_option(word, has_value ? words[i + 1] : "", options);
      if (wrong.empty() && (!has_value || words[i + 1].empty()))
        wrong = word + ": missing value (see --help)";
      if (!wrong.empty()) return wrong;
      ++i;
    } else {
      positional.push_back(word);
    }
  }
  if (positional.size() != 2) return "give one INPUT and one OUTPUT (see --help)";
  options.input = positional[0];
  options.output = positional[1];
  return {};
}

/// Returns what is wrong with the combination of options, or an empty string.
std::string check(const Options& options) {
  const auto format = ingest::export_format_of(options.output);
  if (!format) return "OUTPUT must end with .nii, .nii.gz, .stl or .glb";
  const bool is_surface =
      *format == ingest::ExportFormat::kStl || *format == ingest::ExportFormat::kGlb;
  const int chosen = (options.label.empty() ? 0 : 1) + (options.above ? 1 : 0);
  if (is_surface && chosen != 1) return "a surface needs either --label or --above (see --help)";
  if (!is_surface && chosen != 0)
    return "NIfTI contains the whole scan; --label and --above are for .stl and .glb";
  if (options.phase && !options.above) return "--phase is for --above (see --help)";
  return {};
}

/// Returns the number of the label with this name, or else with this number.
Result<std::uint32_t> number_of(const volume::LabelSet& set, const std::string& name) {
  std::vector<std::uint32_t> numbers;
  for (const auto& entry : set.table) {
    if (volume::name_of(entry) == name) numbers.push_back(entry.number);
  }
  if (numbers.size() == 1) return numbers.front();
  for (const auto& entry : set.table) {
    if (std::to_string(entry.number) == name) return entry.number;
  }
  std::string known;
  for (const auto& entry : set.table)
    known += "\n  " + std::to_string(entry.number) + "  " + volume::name_of(entry);
  if (known.empty()) known = " none (add some with --labels FILE)";
  return fail(ErrorCode::kInvalid, (numbers.empty() ? "the scan has no label '" + name + "'"
                                                    : "several labels are called '" + name + "'") +
                                       "; it has:" + known);
}

Result<ingest::ExportOrder> prepare(const Options& options, volume::Volume& scan) {
  ingest::ExportOrder order;
  order.format = *ingest::export_format_of(options.output);
  order.above = options.above;
  if (options.above) {
    order.phase = options.phase.value_or(0);
    if (auto kept = volume::keep_phase(scan, order.phase); !kept) {
      return fail(ErrorCode::kInvalid, "--phase: " + kept.error().message);
    }
  }
  if (options.label.empty()) return order;
  if (!options.label_file.empty()) {
    auto set = ingest::read_label_file(options.label_file, scan.header);
    DIAPHANE_TRY(set);
    scan.label_set = *std::move(set);
  }
  if (scan.labels.empty()) scan.labels = ingest::found_labels(scan);
  volume::list_found_labels(scan);
  const auto number = number_of(scan.label_set, options.label);
  DIAPHANE_TRY(number);
  order.label = *number;
  return order;
}

/// Returns the name under which the file is written first.
std::string unfinished_name(const Options& options) { return options.output + ".part"; }

/// Writes the file under another name first, so that nobody finds a part of it.
Result<void> write(const volume::Volume& scan, const ingest::ExportOrder& order,
                   const Options& options) {
  const std::string unfinished = unfinished_name(options);
  std::FILE* file = std::fopen(unfinished.c_str(), "wb");
  const auto failed = [&] { return fail(ErrorCode::kUnavailable, "cannot write the file"); };
  if (file == nullptr) return failed();
  const auto written =
      ingest::export_scan(scan, order, options.limits, [&](std::string_view bytes) -> Result<void> {
        if (std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size()) return failed();
        return {};
      });
  const bool closed = std::fclose(file) == 0;
  std::error_code error;
  if (written && closed) fs::rename(unfinished, options.output, error);
  if (!written || !closed || error) {
    std::error_code ignored;
    fs::remove(unfinished, ignored);
  }
  DIAPHANE_TRY(written);
  if (!closed || error) return failed();
  return {};
}

int run(const Options& options) {
  std::error_code error;
  for (const std::string& file : {options.output, unfinished_name(options)}) {
    if (fs::exists(file, error) && !options.force)
      return complain(kExitNoOutput, file + ": already exists (--force replaces it)");
  }
  auto scan = ingest::read_scan(options.input);
  if (!scan) return complain(kExitNoInput, options.input + ": " + scan.error().message);
  const auto order = prepare(options, *scan);
  if (!order) return complain(kExitData, order.error().message);
  const auto written = write(*scan, *order, options);
  if (written) return 0;
  const bool unwritable = written.error().code == ErrorCode::kUnavailable;
  return complain(unwritable ? kExitNoOutput : kExitData,
                  (unwritable ? options.output + ": " : "") + written.error().message);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  for (const std::string& word : words) {
    if (word == "--help" || word == "-h") {
      std::fputs(kUsage, stdout);
      return 0;
    }
  }
  Options options;
  std::string wrong = read_options(words, options);
  if (wrong.empty()) wrong = check(options);
  if (!wrong.empty()) return complain(kExitUsage, wrong);
  return run(options);
}
