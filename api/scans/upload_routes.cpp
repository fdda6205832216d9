#include "api/routing/problem_document.h"
#include "api/routing/representations.h"
#include "api/routing/request_fields.h"
#include "api/scans/routes.h"
#include "api/scans/tus.h"
#include "common/try.h"

namespace diaphane::api {
namespace {

Response with_progress(Response response, const Upload& upload) {
  response.with("Upload-Offset", std::to_string(upload.received));
  if (upload.state == DataSetState::kUploading) {
    response.with("Upload-Expires", http_date(upload.expires_at));
  }
  return response;
}

/// Makes the handler check the tus version before anything else (tus 1.0, "Tus-Resumable").
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

/// Announces a data set like POST /v1/data-sets, but with the headers of tus' creation extension.
/// Uses only `title` and `filetype` of the metadata, never a file name.
Outcome<Response> create_upload(DataSets& data_sets, const Request& request, const Principal& who) {
  auto key = idempotency_key(request);
  DIAPHANE_TRY(key);
  const auto plan =
      tus::plan_creation({request.header("upload-length"), request.header("upload-metadata")});
  DIAPHANE_TRY(plan);
  if (!request.body.empty()) {
    // creation-with-upload is not supported: data is sent only after the upload is accepted.
    return refuse_field("body", "must be empty; send the parts with PATCH");
  }
  const auto& fields = plan->metadata;
  if (const auto type = fields.find("filetype");
      type != fields.end() && type->second != "application/x-tar") {
    return refuse(ProblemKind::kMediaType, "Upload one series as a single tar file.");
  }
  const auto title = fields.find("title");
  Fields in("Upload-Metadata", {{"title", title == fields.end() ? std::string() : title->second}});
  DataSets::Announcement announcement{in.name("title", 0, 80), plan->length, *std::move(key)};
  if (auto wrong = in.finish()) return tl::unexpected(*wrong);
  const auto made = data_sets.announce(who, announcement);
  DIAPHANE_TRY(made);
  auto response = empty_response(201).with("Location", "/v1/uploads/" + made->id);
  return made->upload ? with_progress(std::move(response), *made->upload) : response;
}

}  // namespace

std::vector<Route> upload_routes(Uploads& uploads, DataSets& data_sets) {
  const std::int64_t max_upload_bytes = data_sets.options().max_upload_bytes;
  const auto create_one = [&data_sets](const Request& request, const Principal& who) {
    return create_upload(data_sets, request, who);
  };
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
    DIAPHANE_TRY(upload);
    return with_progress(empty_response(200), *upload)
        .with("Upload-Length", std::to_string(upload->length));
  };
  const auto append = [&uploads](const Request& request,
                                 const Principal& who) -> Outcome<Response> {
    if (request.header("content-type") != "application/offset+octet-stream") {
      return refuse(ProblemKind::kMediaType,
                    "The content type of a part must be application/offset+octet-stream.");
    }
    const auto upload =
        uploads.append(who, request.parameter("upload_id"), request.header("upload-offset"),
                       request.header("upload-checksum"), request.body);
    DIAPHANE_TRY(upload);
    return with_progress(empty_response(204), *upload);
  };
  const auto may_append = [&uploads](const Request& request, const Principal& who,
                                     std::int64_t bytes) -> Outcome<void> {
    return uploads.check_part(who, request.parameter("upload_id"), request.header("upload-offset"),
                              request.header("upload-checksum"), bytes);
  };
  const auto terminate = [&uploads](const Request& request,
                                    const Principal& who) -> Outcome<Response> {
    const auto done = uploads.terminate(who, request.parameter("upload_id"));
    DIAPHANE_TRY(done);
    return empty_response(204);
  };
  const std::string one = "/v1/uploads/{upload_id}";
  constexpr auto kAccess = Access::kPersonOrOperator;
  return {
      {"OPTIONS", "/v1/uploads", "discoverUploads", Access::kAnyone, discover, {}},
      {"POST", "/v1/uploads", "createUpload", kAccess, speaking_tus(create_one), {}},
      {"OPTIONS", one, "discoverUploads", Access::kAnyone, discover, {}},
      {"HEAD", one, "getUploadOffset", kAccess, speaking_tus(offset), {}},
      {"PATCH",
       one,
       "appendToUpload",
       kAccess,
       speaking_tus(append),
       {},
       tus::kMaxPartBytes,
       may_append},
      {"DELETE", one, "terminateUpload", kAccess, speaking_tus(terminate), {}},
  };
}

}  // namespace diaphane::api
