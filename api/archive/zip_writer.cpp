#include "api/archive/zip_writer.h"

#include <archive.h>
#include <archive_entry.h>

#include <array>
#include <filesystem>
#include <fstream>

namespace diaphane::api {
namespace {

struct FreeArchive {
  void operator()(archive* one) const { archive_write_free(one); }
};
struct FreeEntry {
  void operator()(archive_entry* one) const { archive_entry_free(one); }
};

tl::unexpected<Error> cannot_write() {
  return fail(ErrorCode::kUnavailable, "cannot write the export");
}

}  // namespace

struct ZipWriter::Impl {
  std::string path;
  std::unique_ptr<archive, FreeArchive> file;

  Result<void> begin(const std::string& name, std::int64_t size) const {
    const std::unique_ptr<archive_entry, FreeEntry> entry(archive_entry_new());
    archive_entry_set_pathname(entry.get(), name.c_str());
    archive_entry_set_size(entry.get(), size);
    archive_entry_set_filetype(entry.get(), AE_IFREG);
    archive_entry_set_perm(entry.get(), 0644);
    if (archive_write_header(file.get(), entry.get()) != ARCHIVE_OK) return cannot_write();
    return {};
  }
  Result<void> write(std::string_view bytes) const {
    while (!bytes.empty()) {
      const auto written = archive_write_data(file.get(), bytes.data(), bytes.size());
      if (written <= 0) return cannot_write();
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return {};
  }
};

ZipWriter::ZipWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ZipWriter::~ZipWriter() = default;

Result<std::unique_ptr<ExportFile>> ZipWriter::create(const std::string& path) {
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->file.reset(archive_write_new());
  archive* file = impl->file.get();
  const bool made = file != nullptr && archive_write_set_format_zip(file) == ARCHIVE_OK &&
                    archive_write_set_options(
                        file, "zip:compression=deflate,zip:compression-level=1") == ARCHIVE_OK &&
                    archive_write_open_filename(file, path.c_str()) == ARCHIVE_OK;
  if (!made) return cannot_write();
  return std::unique_ptr<ExportFile>(new ZipWriter(std::move(impl)));
}

Result<void> ZipWriter::add(const std::string& name, std::string_view text) {
  if (auto begun = impl_->begin(name, static_cast<std::int64_t>(text.size())); !begun) return begun;
  return impl_->write(text);
}

Result<void> ZipWriter::add_file(const std::string& name, const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || !in) return fail(ErrorCode::kNotFound, "a file of the export has disappeared");
  if (auto begun = impl_->begin(name, static_cast<std::int64_t>(size)); !begun) return begun;
  std::vector<char> part(std::size_t{1} << 20);
  std::uintmax_t left = size;
  while (left > 0 && in.read(part.data(), static_cast<std::streamsize>(part.size())).gcount() > 0) {
    const auto got = std::min<std::uintmax_t>(static_cast<std::uintmax_t>(in.gcount()), left);
    if (auto done = impl_->write({part.data(), static_cast<std::size_t>(got)}); !done) return done;
    left -= got;
  }
  if (left > 0) return fail(ErrorCode::kNotFound, "a file of the export has disappeared");
  return {};
}

Result<std::int64_t> ZipWriter::finish() {
  if (archive_write_close(impl_->file.get()) != ARCHIVE_OK) return cannot_write();
  std::error_code error;
  const auto size = std::filesystem::file_size(impl_->path, error);
  if (error) return cannot_write();
  return static_cast<std::int64_t>(size);
}

}  // namespace diaphane::api
