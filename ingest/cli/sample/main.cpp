#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>

#include "common/config.h"
#include "common/try.h"
#include "ingest/build/keep_phases.h"
#include "ingest/build/nifti.h"
#include "ingest/cli/sample/cranium.h"
#include "ingest/cli/sample/dicom_series.h"
#include "ingest/cli/sample/upload.h"
#include "volume/volume.h"

namespace {

using namespace diaphane;

constexpr int kExitData = 65;          // sysexits.h: EX_DATAERR
constexpr int kExitNoInput = 66;       // EX_NOINPUT
constexpr int kExitUnavailable = 69;   // EX_UNAVAILABLE
constexpr int kExitCannotCreate = 73;  // EX_CANTCREAT

int report(const Error& error, int exit_code) {
  std::fprintf(stderr, "diaphane-sample: %s\n", error.message.c_str());
  return exit_code;
}

Result<std::string> bundle_of(const volume::Volume& volume, std::size_t& files) {
  sample::Bundle bundle;
  auto done =
      sample::write_series(volume, [&](const std::string& file) { return bundle.add(file); });
  DIAPHANE_TRY(done);
  files = bundle.files();
  return bundle.finish();
}

/// Returns the bytes of a file, unpacked if it is compressed by gzip.
std::string unpacked(const std::string& path) {
  std::string bytes;
  const std::unique_ptr<gzFile_s, int (*)(gzFile_s*)> file(gzopen(path.c_str(), "rb"), gzclose);
  if (!file) return {};
  std::array<char, 1 << 16> part{};
  for (int n = 0; (n = gzread(file.get(), part.data(), part.size())) != 0;) {
    if (n < 0) return {};
    bytes.append(part.data(), static_cast<std::size_t>(n));
  }
  return bytes;
}

/// Returns a bundle of a NIfTI file that states its modality, as the page writes it.
Result<std::string> bundle_of(const std::string& path, const std::string& modality,
                              const ingest::PhaseChoice& phases) {
  // Offset and length of intent_name in the header of NIfTI-1 and NIfTI-2.
  constexpr std::size_t kFirst = 328, kSecond = 508, kBytes = 16;
  std::string bytes = unpacked(path);
  const std::size_t intent_name = bytes.substr(0, 8).find("n+2") == 4 ? kSecond : kFirst;
  if (bytes.size() < intent_name + kBytes) {
    return fail(ErrorCode::kNotFound, "cannot read the NIfTI file " + path);
  }
  if (!phases.is_all()) {
    const auto file = std::as_bytes(std::span(bytes));
    const auto header = ingest::read_nifti_header(file);
    DIAPHANE_TRY(header);
    const auto count = std::max<std::size_t>(header->phases.size(), 1);
    const auto kept = ingest::chosen_phases(phases, static_cast<std::uint32_t>(count));
    DIAPHANE_TRY(kept);
    bytes = ingest::keep_nifti_phases(file, *header, *kept);
  }
  if (!modality.empty()) {
    std::string name = modality.substr(0, kBytes - 1);
    name.resize(kBytes, '\0');
    bytes.replace(intent_name, kBytes, name);
  }
  sample::Bundle bundle;
  DIAPHANE_TRY(bundle.add(bytes));
  return bundle.finish();
}

int send(const std::string& bundle, std::size_t files, sample::UploadOptions options,
         const std::string& token_file) {
  std::ifstream in(token_file);
  if (!std::getline(in, options.token) || options.token.empty()) {
    return report({ErrorCode::kNotFound, "cannot read the token file " + token_file, {}},
                  kExitNoInput);
  }
  if (isatty(STDERR_FILENO)) {
    options.progress = [](std::uint64_t sent, std::uint64_t all) {
      std::fprintf(stderr, "\r%llu of %llu MB", static_cast<unsigned long long>(sent >> 20),
                   static_cast<unsigned long long>(all >> 20));
      if (sent == all) std::fputs("\n", stderr);
    };
  }
  auto id = sample::upload(bundle, files, options);
  if (!id) {
    return report(id.error(),
                  id.error().code == ErrorCode::kUnavailable ? kExitUnavailable : kExitData);
  }
  std::printf("%s\n", id->c_str());
  return 0;
}

/// What the command line requests. A step whose text is empty is skipped.
struct Orders {
  std::string cranium, dicom, bundle, mha, store, file, modality, token_file;
  ingest::PhaseChoice phases;  ///< of `file`
  sample::UploadOptions upload;
};

Orders read_orders(ConfigReader& in) {
  Orders orders;
  orders.cranium =
      in.text("cranium", "path of the InVesalius project Cranium.inv3", sample::kCraniumPath);
  orders.dicom =
      in.text("write-dicom", "write a DICOM series of a fictitious patient to this folder", "");
  orders.bundle = in.text("write-bundle", "write the tar file that a browser would upload", "");
  orders.mha = in.text("mapped-mha",
                       "write the volume for the comparison of renderers to this .mha file", "");
  orders.store = in.text(
      "mapped-volume",
      "write the volume for the comparison of renderers to this directory of the volume store", "");
  orders.upload.url =
      in.text("upload", "upload the scan to this origin as a public sample and print its ID", "");
  orders.token_file =
      in.text("token-file", "file with the sample token; required with --upload", "");
  orders.file =
      in.text("file", "upload this NIfTI file (.nii or .nii.gz) instead of the cranium", "");
  orders.modality = in.text("modality", "what the scan in --file is: CT, MR or PT", "");
  const auto phases = ingest::parse_phases(in.text("phases", ingest::kPhasesHelp, ""),
                                           in.text("every", ingest::kEveryHelp, ""));
  if (!phases) in.mistake(phases.error().message);
  if (phases) orders.phases = *phases;
  if (!orders.phases.is_all() && orders.file.empty())
    in.mistake("--phases and --every require --file");
  orders.upload.title = in.text("title", "title of the uploaded sample", "Cranium");
  const bool uploads = !orders.upload.url.empty();
  if (orders.dicom.empty() && orders.bundle.empty() && orders.mha.empty() && orders.store.empty() &&
      !uploads) {
    in.mistake(
        "nothing to do: set --write-dicom, --write-bundle, --mapped-mha, --mapped-volume or "
        "--upload");
  }
  if (uploads && orders.token_file.empty()) in.mistake("--upload requires --token-file");
  if (!uploads && !orders.file.empty()) in.mistake("--file requires --upload");
  if (!in.words().empty()) in.mistake("unexpected argument: " + in.words().front());
  return orders;
}

int upload_file(const Orders& orders) {
  const auto bytes = bundle_of(orders.file, orders.modality, orders.phases);
  if (!bytes) return report(bytes.error(), kExitNoInput);
  return send(*bytes, 1, orders.upload, orders.token_file);
}

/// Writes or uploads the cranium in each form that is wanted.
int use_cranium(const Orders& orders) {
  const auto read = sample::read_cranium(orders.cranium);
  if (!read) return report(read.error(), kExitNoInput);
  if (!orders.mha.empty()) {
    const auto ok = sample::write_mha(sample::mapped(*read), orders.mha);
    if (!ok) return report(ok.error(), kExitCannotCreate);
  }
  if (!orders.store.empty()) {
    volume::Volume mapped = sample::mapped(*read);
    const auto ok = volume::write(mapped, orders.store);
    if (!ok) return report(ok.error(), kExitCannotCreate);
  }
  const volume::Volume upright = sample::upright(*read);
  if (!orders.dicom.empty()) {
    const auto ok = sample::write_series_folder(upright, orders.dicom);
    if (!ok) return report(ok.error(), kExitCannotCreate);
  }
  if (orders.bundle.empty() && orders.upload.url.empty()) return 0;
  std::size_t files = 0;
  const auto bytes = bundle_of(upright, files);
  if (!bytes) return report(bytes.error(), kExitData);
  if (!orders.bundle.empty()) {
    std::ofstream out(orders.bundle, std::ios::binary | std::ios::trunc);
    out.write(bytes->data(), static_cast<std::streamsize>(bytes->size()));
    out.close();
    if (!out) {
      return report({ErrorCode::kUnavailable, "cannot write the file " + orders.bundle, {}},
                    kExitCannotCreate);
    }
  }
  if (orders.upload.url.empty()) return 0;
  return send(*bytes, files, orders.upload, orders.token_file);
}

}  // namespace

int main(int argc, char** argv) {
  ConfigReader in(argc, argv);
  const Orders orders = read_orders(in);
  if (const auto done = in.finish(
          "diaphane-sample: prepare the sample scan from Debian's invesalius-examples, or upload "
          "samples"))
    return *done;
  return orders.file.empty() ? use_cranium(orders) : upload_file(orders);
}
