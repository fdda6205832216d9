#include "api/service/tus.h"

#include <sodium.h>

#include <charconv>

namespace diaphane::api::tus {
namespace {

std::optional<std::int64_t> parse_offset(std::string_view text) {
  std::int64_t value = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, value);
  if (text.empty() || error != std::errc() || end != last || value < 0) return std::nullopt;
  return value;
}

}  // namespace

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
    return refused("only sha1 and sha256 are known");
  }
  const std::string_view text = header.substr(blank + 1);
  checksum.digest.resize(64);
  std::size_t got = 0;
  if (sodium_base642bin(reinterpret_cast<unsigned char*>(checksum.digest.data()),
                        checksum.digest.size(), text.data(), text.size(), nullptr, &got, nullptr,
                        sodium_base64_VARIANT_ORIGINAL) != 0 ||
      got != size) {
    return refused("is not the base64 of such a digest");
  }
  checksum.digest.resize(got);
  return checksum;
}

bool fits(const Checksum& checksum, std::string_view bytes) {
  return digest(checksum.kind, bytes) == checksum.digest;
}

Outcome<Part> plan_part(const Standing& standing, const PartRequest& request) {
  const auto offset = parse_offset(request.offset);
  if (!offset) return refuse_field("Upload-Offset", "must be a whole number of bytes");
  Part part{*offset, std::nullopt, false};
  if (!request.checksum.empty()) {
    auto checksum = parse_checksum(request.checksum);
    if (!checksum) return tl::unexpected(checksum.error());
    part.checksum = std::move(*checksum);
  }
  if (request.bytes > kMaxPartBytes) {
    return refuse(ProblemKind::kBodyTooLarge, "A part has at most 8 MiB.");
  }
  const bool complete = standing.received == standing.length;
  if (complete && *offset == standing.length && request.bytes == 0) return part;
  if (complete || standing.taken) {
    return refuse(ProblemKind::kUploadComplete, "All of this upload has arrived already.");
  }
  if (standing.expired) {
    return refuse(ProblemKind::kUploadExpired,
                  "This upload was left for too long and has expired; start it anew.");
  }
  if (*offset != standing.received) {
    return refuse(ProblemKind::kOffsetMismatch,
                  "The upload stands at byte " + std::to_string(standing.received) + ".");
  }
  if (request.bytes > standing.length - standing.received) {
    return refuse_field("body", "goes beyond the announced length of the upload");
  }
  part.completes = *offset + request.bytes == standing.length;
  return part;
}

}  // namespace diaphane::api::tus
