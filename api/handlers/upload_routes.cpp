#include "api/handlers/problem_document.h"
#include "api/handlers/representations.h"
#include "api/handlers/routes.h"
#include "api/service/tus.h"

namespace diaphane::api {
namespace {

Response with_standing(Response response, const Upload& upload) {
  response.with("Upload-Offset", std::to_string(upload.received));
  if (upload.state == DataSetState::kUploading) {
    response.with("Upload-Expires", http_date(upload.expires_at));
  }
  return response;
}

/// The version of tus is checked before anything else (tus 1.0, "Tus-Resumable").
Route::Handler speaking_tus(Route::Handler handler) {
  return [handler = std::move(handler)](const Request& request,
                                        const Principal& who) -> Outcome<Response> {
    if (request.header("tus-resumable") != tus::kVersion) {
      auto refused = problem_response({ProblemKind::kTusVersion,
                                       "Tus-Resumable must be " + std::string(tus::kVersion) + ".",
                                       {},
                                       {}},
                                      request.request_id);
      return std::move(refused).with("Tus-Version", std::string(tus::kVersion));
    }
    return handler(request, who);
  };
}

}  // namespace

std::vector<Route> upload_routes(Uploads& uploads, std::int64_t max_upload_bytes) {
  const auto discover = [max_upload_bytes](const Request&, const Principal&) -> Outcome<Response> {
    return empty_response(204)
        .with("Tus-Version", std::string(tus::kVersion))
        .with("Tus-Extension", std::string(tus::kExtensions))
        .with("Tus-Checksum-Algorithm", std::string(tus::kChecksums))
        .with("Tus-Max-Size", std::to_string(max_upload_bytes));
  };
  const auto offset = [&uploads](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    const auto upload = uploads.find(who, request.parameter("upload_id"));
    if (!upload) return tl::unexpected(upload.error());
    return with_standing(empty_response(200), *upload)
        .with("Upload-Length", std::to_string(upload->length));
  };
  const auto append = [&uploads](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    if (request.header("content-type") != "application/offset+octet-stream") {
      return refuse(ProblemKind::kMediaType, "A part is application/offset+octet-stream.");
    }
    const auto upload =
        uploads.append(who, request.parameter("upload_id"), request.header("upload-offset"),
                       request.header("upload-checksum"), request.body);
    if (!upload) return tl::unexpected(upload.error());
    return with_standing(empty_response(204), *upload);
  };
  const auto terminate = [&uploads](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    const auto done = uploads.terminate(who, request.parameter("upload_id"));
    if (!done) return tl::unexpected(done.error());
    return empty_response(204);
  };
  const std::string one = "/v1/uploads/{upload_id}";
  constexpr auto kAccess = Access::kPersonOrOperator;
  return {
      {"OPTIONS", "/v1/uploads", "discoverUploads", Access::kAnyone, discover, {}},
      {"OPTIONS", one, "discoverUploads", Access::kAnyone, discover, {}},
      {"HEAD", one, "getUploadOffset", kAccess, speaking_tus(offset), {}},
      {"PATCH", one, "appendToUpload", kAccess, speaking_tus(append), {}, tus::kMaxPartBytes},
      {"DELETE", one, "terminateUpload", kAccess, speaking_tus(terminate), {}},
  };
}

}  // namespace diaphane::api
