#include "operator/kube/cpprest_transport.h"

#include <cpprest/http_client.h>
#include <pplx/threadpool.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/ssl/context.hpp>
#include <map>
#include <mutex>

namespace diaphane::kube {
namespace {

using std::chrono::milliseconds;
namespace http = web::http;

/// Threads of cpprestsdk for connections. The operator's calls block in their own threads.
constexpr int kThreads = 4;
/// Largest accepted response, far above the size of one page of a list.
constexpr std::size_t kLargest = 256U << 20;

/// Converts exceptions for a missing response: those of cpprestsdk, and standard ones for a closed
/// body.
tl::unexpected<Error> away(const std::exception& why) {
  return fail(ErrorCode::kUnavailable,
              std::string("no response from the API server: ") + why.what());
}

class CpprestTransport final : public Transport {
 public:
  explicit CpprestTransport(const Access& access) : access_(access), token_(access.token_file) {
    static std::once_flag once;
    std::call_once(once, [] { crossplat::threadpool::initialize_with_threads(kThreads); });
  }

  Result<Response> call(const Request& request, milliseconds timeout) override {
    return perform(request, timeout, [](http::http_response& answer) {
      const std::vector<unsigned char> bytes = answer.extract_vector().get();
      return Response{answer.status_code(), std::string(bytes.begin(), bytes.end())};
    });
  }

  Result<Response> stream(const Request& request, milliseconds silence,
                          const std::function<bool(std::string_view)>& bytes) override {
    return perform(request, silence, [&](http::http_response& answer) {
      Response response{answer.status_code(), {}};
      if (response.status != 200) {
        const std::vector<unsigned char> body = answer.extract_vector().get();
        response.body.assign(body.begin(), body.end());
        return response;
      }
      auto body = answer.body().streambuf();
      std::array<std::uint8_t, 16384> piece{};
      if (!bytes({})) return response;
      for (;;) {
        // A read blocks until the requested size arrives, so it requests only what is available,
        // and at least one byte.
        const std::size_t available = std::clamp<std::size_t>(body.in_avail(), 1, piece.size());
        const std::size_t got = body.getn(piece.data(), available).get();
        if (got == 0) return response;
        if (!bytes({reinterpret_cast<const char*>(piece.data()), got})) return response;
      }
    });
  }

  void stop() override {
    stopped_ = true;
    stopping_.cancel();
  }

 private:
  /// Returns the client for a time limit, with its kept connections. A client has a single time
  /// limit.
  std::shared_ptr<http::client::http_client> client(milliseconds timeout) {
    const std::lock_guard lock(mutex_);
    auto& client = clients_[timeout];
    if (!client) {
      http::client::http_client_config config;
      config.set_timeout(timeout);
      config.set_max_redirects(0);
      // Called for each new connection, so that a rotated certificate authority takes effect.
      config.set_ssl_context_callback([file = access_.ca_file](boost::asio::ssl::context& context) {
        if (!file.empty()) context.load_verify_file(file);
      });
      client = std::make_shared<http::client::http_client>(access_.server, config);
    }
    return client;
  }

  template <typename Read>
  Result<Response> perform(const Request& request, milliseconds timeout, const Read& read) {
    if (stopped_) return fail(ErrorCode::kUnavailable, "stopping");
    // Cancels this call alone if the stream ends before its response.
    auto source = pplx::cancellation_token_source::create_linked_source(stopping_token_);
    try {
      http::http_request out(request.method);
      out.set_request_uri(request.query.empty() ? request.path
                                                : request.path + "?" + request.query);
      out.headers().add("Accept", "application/json");
      if (const std::string token = token_.at(std::chrono::steady_clock::now()); !token.empty()) {
        out.headers().add("Authorization", "Bearer " + token);
      }
      if (!request.body.empty()) out.set_body(request.body, request.content_type);
      http::http_response answer = client(timeout)->request(out, source.get_token()).get();
      if (answer.headers().content_length() > kLargest) {
        source.cancel();
        return fail(ErrorCode::kTooLarge, "the response of the API server is too large");
      }
      if (answer.status_code() == 401) token_.refused();
      Response response = read(answer);
      source.cancel();
      return response;
    } catch (const std::exception& why) {
      source.cancel();
      return away(why);
    }
  }

  const Access access_;
  Token token_;
  std::atomic<bool> stopped_{false};
  pplx::cancellation_token_source stopping_;
  pplx::cancellation_token stopping_token_ = stopping_.get_token();
  std::mutex mutex_;
  std::map<milliseconds, std::shared_ptr<http::client::http_client>> clients_;
};

}  // namespace

std::unique_ptr<Transport> make_cpprest_transport(const Access& access) {
  return std::make_unique<CpprestTransport>(access);
}

}  // namespace diaphane::kube
