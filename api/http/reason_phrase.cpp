#include "api/http/reason_phrase.h"

#include <algorithm>
#include <array>
#include <utility>

namespace diaphane::api {
namespace {

/// The statuses that the API or its HTTP library may send.
constexpr std::array kPhrases = std::to_array<std::pair<int, std::string_view>>({
    {200, "OK"},
    {201, "Created"},
    {202, "Accepted"},
    {204, "No Content"},
    {206, "Partial Content"},
    {303, "See Other"},
    {304, "Not Modified"},
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {408, "Request Timeout"},
    {409, "Conflict"},
    {410, "Gone"},
    {411, "Length Required"},
    {412, "Precondition Failed"},
    {413, "Content Too Large"},
    {415, "Unsupported Media Type"},
    {416, "Range Not Satisfiable"},
    {422, "Unprocessable Content"},
    {423, "Locked"},
    {428, "Precondition Required"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {460, "Checksum Mismatch"},
    {500, "Internal Server Error"},
    {501, "Not Implemented"},
    {502, "Bad Gateway"},
    {503, "Service Unavailable"},
    {507, "Insufficient Storage"},
});

constexpr std::array<std::string_view, 5> kClasses{"Informational", "Success", "Redirection",
                                                   "Client Error", "Server Error"};

}  // namespace

std::string_view reason_phrase(int status) {
  const auto* const found = std::find_if(kPhrases.begin(), kPhrases.end(),
                                         [&](const auto& one) { return one.first == status; });
  if (found != kPhrases.end()) return found->second;
  const int first_digit = std::clamp(status / 100, 1, 5);
  return kClasses[static_cast<std::size_t>(first_digit - 1)];
}

}  // namespace diaphane::api
