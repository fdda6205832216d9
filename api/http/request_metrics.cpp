#include "api/http/request_metrics.h"

#include <string>

namespace diaphane::api {
namespace {

using prometheus::BuildCounter;

prometheus::Counter& one_counter(prometheus::Registry& registry, const char* name,
                                 const char* help) {
  return BuildCounter().Name(name).Help(help).Register(registry).Add({});
}

const prometheus::Histogram::BucketBoundaries kSeconds{0.001, 0.003, 0.01, 0.03, 0.1,
                                                       0.3,   1,     3,    10};

}  // namespace

RequestMetrics::RequestMetrics(prometheus::Registry& registry)
    : requests_(BuildCounter()
                    .Name("diaphane_api_requests_total")
                    .Help("Requests handled, by operation and status.")
                    .Register(registry)),
      seconds_(prometheus::BuildHistogram()
                   .Name("diaphane_api_request_seconds")
                   .Help("Time spent in the handler, by operation.")
                   .Register(registry)),
      upload_bytes_(
          one_counter(registry, "diaphane_api_upload_bytes_total", "Upload bytes stored.")),
      mails_sent_(one_counter(registry, "diaphane_api_mails_sent_total", "Emails sent.")),
      mails_failed_(one_counter(registry, "diaphane_api_mails_failed_total",
                                "Failed attempts to send an email.")),
      disposals_(one_counter(registry, "diaphane_api_disposals_total",
                             "Uploads and volumes deleted from disk.")),
      waiting_(prometheus::BuildGauge()
                   .Name("diaphane_api_requests_waiting")
                   .Help("Requests waiting for a thread.")
                   .Register(registry)
                   .Add({})) {}

void RequestMetrics::measured(const Measured& request) {
  requests_.Add({{"operation", request.operation}, {"status", std::to_string(request.status)}})
      .Increment();
  seconds_.Add({{"operation", request.operation}}, kSeconds).Observe(request.seconds);
  if (request.operation == "appendToUpload" && request.status == 204) {
    upload_bytes_.Increment(static_cast<double>(request.body_bytes));
  }
}

void RequestMetrics::mails(int sent, int failed) {
  mails_sent_.Increment(sent);
  mails_failed_.Increment(failed);
}

}  // namespace diaphane::api
