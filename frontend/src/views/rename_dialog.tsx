import { useState } from "preact/hooks";
import type { DataSet } from "../api/types";
import { t } from "../texts";
import { CancelButton, Dialog } from "./dialog";
import { Field } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { useApp } from "./state";

export interface RenameDialogProps {
  readonly set: DataSet;
  readonly rename: (set: DataSet, title: string) => Promise<void>;
  readonly onClose: () => void;
}

export function RenameDialog({ set, rename, onClose }: RenameDialogProps) {
  const app = useApp();
  const [title, setTitle] = useState(set.title);
  const [faults, setFaults] = useState<Faults<"title">>({});
  const [busy, setBusy] = useState(false);
  const submit = async () => {
    setBusy(true);
    try {
      await rename(set, title.trim());
      onClose();
    } catch (thrown) {
      setFaults(faultsOf(thrown, ["title"], (what) => app.explain(what)));
      setBusy(false);
    }
  };
  return (
    <Dialog title={t.scans.renameTitle} onClose={onClose}>
      <Form onSubmit={submit} busy={busy} label={t.scans.renameSave} {...fault(faults.form)}>
        <Field
          label={t.sharing.details.name}
          value={title}
          onInput={setTitle}
          most={80}
          hint={t.sharing.details.nameHint}
          {...fault(faults.title)}
        />
      </Form>
      <CancelButton onClick={onClose} />
    </Dialog>
  );
}
