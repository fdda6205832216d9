"""`diaphane-api migrate`: up, down and up again, and its messages for mistakes."""

from __future__ import annotations

import os
import subprocess
import uuid

import pytest


@pytest.fixture
def database(stores):
    """A separate empty database."""
    name = f"migrate_{uuid.uuid4().hex[:8]}"
    superuser = (stores.data_dir / "secrets" / "postgres-superuser").read_text(encoding="utf-8").strip()
    import psycopg

    admin = f"postgresql://postgres:{superuser}@127.0.0.1:{stores.ports['postgres']}/postgres"
    with psycopg.connect(admin, autocommit=True) as connection:
        connection.execute(f'CREATE DATABASE "{name}"')
    yield f"postgresql://postgres:{superuser}@127.0.0.1:{stores.ports['postgres']}/{name}"
    with psycopg.connect(admin, autocommit=True) as connection:
        connection.execute(f'DROP DATABASE "{name}" WITH (FORCE)')


def migrate(stack, database: str, *words: str, migrations=None) -> subprocess.CompletedProcess:
    layout = stack.stack.layout
    environment = {**os.environ, "DIAPHANE_POSTGRES": database}
    return subprocess.run([str(layout.bin / "diaphane-api"), "migrate", *words, "--migrations",
                           str(migrations or layout.migrations)], env=environment, capture_output=True, text=True)


def schema(database: str) -> list[tuple]:
    import psycopg

    with psycopg.connect(database) as connection:
        return connection.execute("""
            SELECT table_name, column_name, data_type, is_nullable, column_default FROM information_schema.columns
             WHERE table_schema = 'public' UNION ALL
            SELECT tablename, indexname, indexdef, '', '' FROM pg_indexes WHERE schemaname = 'public'
             ORDER BY 1, 2""").fetchall()


@pytest.mark.parametrize("newest", [2, pytest.param(1000, marks=pytest.mark.nightly, id="all")])
def test_migrating_up_down_and_up_gives_the_same_schema(stores, database, newest):
    names = sorted(path.name.removesuffix(".up.sql") for path in stores.stack.layout.migrations.glob("*.up.sql"))
    assert len(names) >= 4 and [name[:4] for name in names] == sorted({name[:4] for name in names})
    assert migrate(stores, database, "up").stdout.split() == [word for name in names for word in ("up", name)]
    whole = schema(database)
    assert {"users", "data_sets", "uploads", "ingest_jobs", "schema_migrations"} <= {row[0] for row in whole}
    assert migrate(stores, database, "up").stdout == "nothing to do\n"
    # The newest ones one by one, and each migration up again restores the previous state.
    for name in list(reversed(names[1:]))[:newest]:
        before = schema(database)
        assert migrate(stores, database, "down").stdout.split() == ["down", name]
        below = schema(database)
        assert migrate(stores, database, "up", "--steps", "1").stdout.split() == ["up", name]
        assert schema(database) == before
        assert migrate(stores, database, "down").stdout.split() == ["down", name]
        assert schema(database) == below
    below = [name for name in reversed(names) if name not in names[1:][-newest:]]
    assert migrate(stores, database, "down", "--steps", "1000").stdout.split() == [word for name in below for word in ("down", name)]
    assert {row[0] for row in schema(database)} == {"schema_migrations"}
    assert migrate(stores, database, "up", "--steps", "1").stdout.split() == ["up", "0001_accounts"]
    assert migrate(stores, database, "up").returncode == 0
    assert schema(database) == whole


def test_concurrent_migrations_wait_for_each_other(stores, database):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(4) as pool:
        done = list(pool.map(lambda _: migrate(stores, database, "up"), range(4)))
    assert [d.returncode for d in done] == [0] * 4, [d.stderr for d in done]
    assert sum("0001_accounts" in d.stdout for d in done) == 1


def test_a_failed_migration_is_rolled_back(stores, database, tmp_path):
    (tmp_path / "0001_good.up.sql").write_text("CREATE TABLE good (a int);")
    (tmp_path / "0002_bad.up.sql").write_text("CREATE TABLE half (a int); SELECT nonsense;")
    done = migrate(stores, database, "up", migrations=tmp_path)
    assert done.returncode == 1 and "0002_bad" in done.stderr
    assert {row[0] for row in schema(database)} == {"good", "schema_migrations"}


def test_migration_errors_have_exit_codes(stores, database, tmp_path):
    assert migrate(stores, database, "sideways").returncode == 78
    assert migrate(stores, database, "up", "--surprise", "1").returncode == 64
    assert migrate(stores, database, "up", migrations=tmp_path).returncode == 1
    away = migrate(stores, "postgresql://nobody@127.0.0.1:1/none", "up")
    assert away.returncode == 69 and "unavailable" in away.stderr
