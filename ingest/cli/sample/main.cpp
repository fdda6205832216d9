#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "common/config.h"
#include "common/try.h"
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

int send(const volume::Volume& volume, sample::UploadOptions options,
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
  std::size_t files = 0;
  auto bundle = bundle_of(volume, files);
  if (!bundle) return report(bundle.error(), kExitData);
  auto id = sample::upload(*bundle, files, options);
  if (!id) {
    return report(id.error(),
                  id.error().code == ErrorCode::kUnavailable ? kExitUnavailable : kExitData);
  }
  std::printf("%s\n", id->c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  ConfigReader in(argc, argv);
  const std::string cranium =
      in.text("cranium", "path of the InVesalius project Cranium.inv3", sample::kCraniumPath);
  const std::string dicom =
      in.text("write-dicom", "write a DICOM series of a fictitious patient to this folder", "");
  const std::string bundle =
      in.text("write-bundle", "write the tar file that a browser would upload", "");
  const std::string mha = in.text(
      "mapped-mha", "write the volume for the comparison of renderers to this .mha file", "");
  const std::string store = in.text(
      "mapped-volume",
      "write the volume for the comparison of renderers to this directory of the volume store", "");
  sample::UploadOptions upload;
  upload.url =
      in.text("upload", "upload the scan to this origin as the public sample and print its ID", "");
  const std::string token_file =
      in.text("token-file", "file with the sample token; required with --upload", "");
  upload.title = in.text("title", "title of the uploaded sample", "Cranium");
  if (dicom.empty() && bundle.empty() && mha.empty() && store.empty() && upload.url.empty()) {
    in.mistake(
        "nothing to do: set --write-dicom, --write-bundle, --mapped-mha, --mapped-volume or "
        "--upload");
  }
  if (!upload.url.empty() && token_file.empty()) in.mistake("--upload requires --token-file");
  if (!in.words().empty()) in.mistake("unexpected argument: " + in.words().front());
  if (auto done = in.finish(
          "diaphane-sample: prepare or upload the sample scan from Debian's invesalius-examples"))
    return *done;

  auto read = sample::read_cranium(cranium);
  if (!read) return report(read.error(), kExitNoInput);
  if (!mha.empty()) {
    if (auto ok = sample::write_mha(sample::mapped(*read), mha); !ok)
      return report(ok.error(), kExitCannotCreate);
  }
  if (!store.empty()) {
    volume::Volume mapped = sample::mapped(*read);
    if (auto ok = volume::write(mapped, store); !ok) return report(ok.error(), kExitCannotCreate);
  }
  const volume::Volume upright = sample::upright(*read);
  if (!dicom.empty()) {
    if (auto ok = sample::write_series_folder(upright, dicom); !ok)
      return report(ok.error(), kExitCannotCreate);
  }
  if (!bundle.empty()) {
    std::size_t files = 0;
    auto bytes = bundle_of(upright, files);
    if (!bytes) return report(bytes.error(), kExitData);
    std::ofstream out(bundle, std::ios::binary | std::ios::trunc);
    out.write(bytes->data(), static_cast<std::streamsize>(bytes->size()));
    out.close();
    if (!out)
      return report({ErrorCode::kUnavailable, "cannot write the file " + bundle, {}},
                    kExitCannotCreate);
  }
  return upload.url.empty() ? 0 : send(upright, std::move(upload), token_file);
}
