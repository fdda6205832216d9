"""The operator exports every metric in the dashboard's queries about it. For other programs: tests/integration/test_dashboard.py.
"""

from __future__ import annotations

from conftest import wait_for
from dashboard_helpers import unanswered


def test_every_operator_query_of_the_dashboard_has_data(cluster):
    cluster.nodes(1)
    operator = cluster.operator()
    cluster.fleet(replicas=1)
    cluster.settled(1)
    wait_for(lambda: not unanswered(("diaphane_operator_",), operator.metrics()), "an answer to every query")
