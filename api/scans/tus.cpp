#include "api/scans/tus.h"

#include <sodium.h>

#include <charconv>

#include "common/try.h"

namespace diaphane::api::tus {
namespace {

std::optional<std::int64_t> parse_offset(std::string_view text) {
  std::int64_t value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (text.empty() || error != std::errc() || end != last || value < 0) return std::nullopt;
  return value;
}

/// Decodes base64. Returns nothing if the text is malformed or has more than `most` bytes.
std::optional<std::string> decode_base64(std::string_view text, std::size_t most) {
  std::string bytes(most, '\0');
  std::size_t got = 0;
  if (sodium_base642bin(reinterpret_cast<unsigned char*>(bytes.data()), bytes.size(), text.data(),
                        text.size(), nullptr, &got, nullptr, sodium_base64_VARIANT_ORIGINAL) != 0) {
    return std::nullopt;
  }
  bytes.resize(got);
  return bytes;
}

constexpr std::size_t kMostMetadataBytes = 2000;

}  // namespace

Outcome<Creation> plan_creation(const CreationRequest& request) {
  const auto length = parse_offset(request.length);
  if (!length || *length == 0) {
    return refuse_field("Upload-Length", "must be a whole number of bytes, at least 1");
  }
  Creation creation{*length, {}};
  std::string_view rest = request.metadata;
  while (!rest.empty()) {
    const std::size_t comma = rest.find(',');
    std::string_view pair = rest.substr(0, comma);
    rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    while (pair.starts_with(' ')) pair.remove_prefix(1);
    const std::size_t blank = pair.find(' ');
    const std::string_view key = pair.substr(0, blank);
    const std::string_view text =
        blank == std::string_view::npos ? std::string_view() : pair.substr(blank + 1);
    auto value = decode_base64(text, kMostMetadataBytes);
    if (key.empty() || !value ||
        !creation.metadata.emplace(std::string(key), *std::move(value)).second) {
      return refuse_field("Upload-Metadata",
                          "must be a comma-separated list of `key base64` pairs");
    }
  }
  return creation;
}

Outcome<Checksum> parse_checksum(std::string_view header) {
  const auto refused = [](const char* why) { return refuse_field("Upload-Checksum", why); };
  const std::size_t blank = header.find(' ');
  if (blank == std::string_view::npos) return refused("must be `sha1 <base64>`");
  const std::string_view name = header.substr(0, blank);
  Checksum checksum;
  std::size_t size = 0;
  if (name == "sha1") {
    checksum.kind = DigestKind::kSha1;
    size = 20;
  } else if (name == "sha256") {
    checksum.kind = DigestKind::kSha256;
    size = 32;
  } else {
    return refused("only sha1 and sha256 are supported");
  }
  auto digest = decode_base64(header.substr(blank + 1), 64);
  if (!digest || digest->size() != size)
    return refused("must be the base64 form of a digest of this type");
  checksum.digest = *std::move(digest);
  return checksum;
}

bool fits(const Checksum& checksum, std::string_view bytes) {
  return digest(checksum.kind, bytes) == checksum.digest;
}

Outcome<Part> plan_part(const UploadProgress& progress, const PartRequest& request) {
  const auto offset = parse_offset(request.offset);
  if (!offset) return refuse_field("Upload-Offset", "must be a whole number of bytes");
  Part part{*offset, std::nullopt, false};
  if (!request.checksum.empty()) {
    auto checksum = parse_checksum(request.checksum);
    DIAPHANE_TRY(checksum);
    part.checksum = std::move(*checksum);
  }
  if (request.bytes > kMaxPartBytes) {
    return refuse(ProblemKind::kBodyTooLarge, "A part may be at most 8 MiB.");
  }
  const bool complete = progress.received == progress.length;
  if (complete && *offset == progress.length && request.bytes == 0) return part;
  if (complete || progress.taken) {
    return refuse(ProblemKind::kUploadComplete, "This upload is already complete.");
  }
  if (progress.expired) {
    return refuse(ProblemKind::kUploadExpired,
                  "This upload was inactive for too long and has expired. Start it again.");
  }
  if (*offset != progress.received) {
    return refuse(ProblemKind::kOffsetMismatch,
                  "The next byte of this upload is " + std::to_string(progress.received) + ".");
  }
  if (request.bytes > progress.length - progress.received) {
    return refuse_field("body", "exceeds the announced length of the upload");
  }
  part.completes = *offset + request.bytes == progress.length;
  return part;
}

}  // namespace diaphane::api::tus
