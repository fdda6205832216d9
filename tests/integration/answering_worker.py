"""A render worker that renders nothing but answers what api asks of it."""

from __future__ import annotations

import functools
import os
from concurrent import futures

# Other tests of this process fork. gRPC would restart its threads in their children, which then hang.
os.environ["GRPC_ENABLE_FORK_SUPPORT"] = "0"
import grpc  # noqa: E402


def address() -> str:
    """Returns the address of this process's worker, which starts with the first call."""
    return f"127.0.0.1:{_started()[1]}"


@functools.cache
def _started() -> tuple[grpc.Server, int]:
    """Returns the server and its port. The cache keeps the server, which would otherwise stop when it is collected."""
    # An empty message is a curve without points.
    curve = grpc.unary_unary_rpc_method_handler(lambda request, context: b"")
    server = grpc.server(futures.ThreadPoolExecutor(2))
    server.add_generic_rpc_handlers([grpc.method_handlers_generic_handler("diaphane.v1.RenderWorker", {"GetErrorCurve": curve})])
    port = server.add_insecure_port("127.0.0.1:0")
    server.start()
    return server, port
