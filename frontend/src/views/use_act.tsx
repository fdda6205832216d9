import { useState } from "preact/hooks";
import { Notice } from "./shell";
import { useApp } from "./state";

/** Runs one action at a time. `outcome` is the text that the last one returned, or its error. */
export function useAct() {
  const app = useApp();
  const [message, setMessage] = useState("");
  const [fault, setFault] = useState("");
  const [busy, setBusy] = useState(false);
  const act = (work: () => Promise<string>) => {
    setBusy(true);
    setMessage("");
    setFault("");
    work()
      .then(setMessage, (thrown: unknown) => setFault(app.explain(thrown)))
      .finally(() => setBusy(false));
  };
  const outcome = (
    <>
      <p class="muted" role="status">
        {message}
      </p>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
    </>
  );
  return { app, act, busy, outcome };
}
