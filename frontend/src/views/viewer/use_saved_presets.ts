import { useCallback, useEffect, useMemo, useState } from "preact/hooks";
import { ApiProblem } from "../../api/client";
import type { DataSet, PresetInfo } from "../../api/types";
import { t } from "../../texts";
import { oneAtATime } from "../one_at_a_time";
import { UserError, useApp } from "../state";

const mostFileBytes = 256 * 1024;

/** Runs a change of the list and returns a message for the user. */
export type ActOnPresets = (work: () => Promise<string>) => void;

/** The saved presets of a scan, and the result of the last change. The list is read again after each change. */
export function useSavedPresets(set: DataSet) {
  const app = useApp();
  const [list, setList] = useState<readonly PresetInfo[] | null>(null);
  const [message, setMessage] = useState("");
  const [fault, setFault] = useState("");
  const reload = useCallback(async () => setList(await app.api.presets.list(set.id)), [app, set.id]);
  useEffect(() => {
    reload().catch((thrown: unknown) => setFault(app.explain(thrown)));
  }, [app, reload]);
  const act = useMemo<ActOnPresets>(
    () =>
      oneAtATime((work) => {
        setMessage("");
        setFault("");
        return work()
          .then(setMessage, (thrown: unknown) => {
            const stale = thrown instanceof ApiProblem && thrown.status === 412;
            setFault(stale ? t.presets.changed : app.explain(thrown));
          })
          .then(reload)
          .catch(() => undefined);
      }),
    [app, reload],
  );
  const importFile = (file: File) =>
    act(async () => {
      if (file.size > mostFileBytes) return t.presets.tooLarge;
      try {
        return t.presets.saved((await app.api.presets.importXml(set.id, file)).name);
      } catch (thrown) {
        if (isNoPreset(thrown)) throw new UserError(t.presets.notAPreset);
        throw thrown;
      }
    });
  return { list, message, fault, act, importFile };
}

/**
 * Whether the server rejected the file as not being a preset. A preset of a later version has a
 * message of its own.
 */
const isNoPreset = (thrown: unknown): boolean =>
  thrown instanceof ApiProblem && thrown.errors.length > 0 && thrown.errors[0]?.field !== "version";
