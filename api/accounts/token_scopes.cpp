#include "api/accounts/token_scopes.h"

#include <algorithm>
#include <map>

namespace diaphane::api {
namespace {

using enum TokenScope;

const std::map<std::string_view, TokenScope>& scopes_by_operation() {
  static const std::map<std::string_view, TokenScope> kScopes{
      {"listDataSets", kRead},       {"getDataSet", kRead},
      {"getThumbnail", kRead},       {"getAnonymise", kRead},
      {"listSessions", kRead},       {"createSession", kRead},
      {"getSession", kRead},         {"endSession", kRead},
      {"getErrorCurve", kRead},      {"createTicket", kRead},
      {"listGallery", kRead},        {"listAnnotations", kRead},
      {"listPresets", kRead},        {"getPreset", kRead},
      {"getPresetThumbnail", kRead}, {"requestScanExport", kRead},
      {"getScanExport", kRead},      {"deleteScanExport", kRead},
      {"downloadScanExport", kRead}, {"exportPreset", kRead},
      {"listEnvironments", kRead},   {"getEnvironment", kRead},
      {"getAlignment", kRead},       {"getTour", kRead},
      {"requestAlignment", kWrite},  {"deleteAlignment", kWrite},
      {"createDataSet", kWrite},     {"describeDataSet", kWrite},
      {"deleteDataSet", kWrite},     {"createUpload", kWrite},
      {"getUploadOffset", kWrite},   {"appendToUpload", kWrite},
      {"terminateUpload", kWrite},   {"anonymise", kWrite},
      {"addLabels", kWrite},         {"removeLabels", kWrite},
      {"createAnnotations", kWrite}, {"changeAnnotations", kWrite},
      {"deleteAnnotations", kWrite}, {"createPreset", kWrite},
      {"importPreset", kWrite},      {"setDefaultPreset", kWrite},
      {"changePreset", kWrite},      {"deletePreset", kWrite},
      {"createEnvironment", kWrite}, {"renameEnvironment", kWrite},
      {"deleteEnvironment", kWrite}, {"removeTour", kWrite},
      {"setVisibility", kShare},     {"listPeople", kShare},
      {"shareWithPerson", kShare},   {"changePerson", kShare},
      {"unsharePerson", kShare},     {"listViews", kShare},
      {"listDataSetLinks", kShare},  {"createDataSetLink", kShare},
      {"endDataSetLink", kShare},    {"createLink", kShare},
      {"endLinks", kShare},          {"listArchives", kArchive},
      {"searchArchive", kArchive},   {"listArchiveSeries", kArchive},
      {"startFetch", kArchive},      {"getFetch", kArchive},
      {"cancelFetch", kArchive},     {"recordReceipt", kArchive},
  };
  return kScopes;
}

}  // namespace

std::string_view to_string(TokenScope scope) {
  switch (scope) {
    case kRead:
      return "read";
    case kWrite:
      return "write";
    case kShare:
      return "share";
    case kArchive:
      break;
  }
  return "archive";
}

std::optional<TokenScope> token_scope_of(std::string_view text) {
  for (const TokenScope scope : kTokenScopes) {
    if (text == to_string(scope)) return scope;
  }
  return std::nullopt;
}

std::string join_scopes(const std::vector<TokenScope>& scopes) {
  std::string joined;
  for (const TokenScope scope : kTokenScopes) {
    if (std::find(scopes.begin(), scopes.end(), scope) == scopes.end()) continue;
    joined += (joined.empty() ? "" : " ") + std::string(to_string(scope));
  }
  return joined;
}

std::vector<TokenScope> split_scopes(std::string_view text) {
  std::vector<TokenScope> scopes;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (const auto scope = token_scope_of(text.substr(0, end))) scopes.push_back(*scope);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return scopes;
}

std::optional<TokenScope> scope_of_operation(std::string_view operation) {
  const auto found = scopes_by_operation().find(operation);
  if (found == scopes_by_operation().end()) return std::nullopt;
  return found->second;
}

}  // namespace diaphane::api
