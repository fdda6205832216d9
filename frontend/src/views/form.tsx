import type { ComponentChildren } from "preact";
import { ApiProblem } from "../api/client";
import { Notice } from "./shell";

/** What is wrong with a form: by field, or (`form`) with all of it. */
export type Faults<Field extends string> = Readonly<Partial<Record<Field | "form", string>>>;

/** What the server said of these fields; else a sentence for the form. */
export function faultsOf<Field extends string>(
  thrown: unknown,
  fields: readonly Field[],
  explain: (thrown: unknown) => string,
): Faults<Field> {
  if (thrown instanceof ApiProblem) {
    const found: Partial<Record<Field, string>> = {};
    for (const field of fields) {
      const message = thrown.errors.find((error) => error.field === field)?.message;
      if (message !== undefined) found[field] = message;
    }
    if (Object.keys(found).length > 0) return found as Faults<Field>;
  }
  return { form: explain(thrown) } as Faults<Field>;
}

/** As a property that may be absent. */
export const fault = (text: string | undefined): { fault?: string } => (text ? { fault: text } : {});

export interface FormProps {
  readonly onSubmit: () => Promise<void>;
  readonly busy: boolean;
  readonly label: string;
  readonly fault?: string;
  readonly danger?: boolean;
  readonly children: ComponentChildren;
}

export function Form({ onSubmit, busy, label, fault, danger, children }: FormProps) {
  return (
    <form
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        const form = event.currentTarget;
        void onSubmit().then(() => {
          // Once the faults are on the page: to the first of them. Without any, back to the button, which a wait has put out of reach.
          requestAnimationFrame(() => {
            const lost = document.activeElement === document.body;
            form.querySelector<HTMLElement>(lost ? "[aria-invalid], [type=submit]" : "[aria-invalid]")?.focus();
          });
        });
      }}
    >
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {children}
      <button
        type="submit"
        class={`button ${danger ? "button-danger" : "button-main"} button-wide`}
        disabled={busy}
        aria-busy={busy}
      >
        {label}
      </button>
    </form>
  );
}
