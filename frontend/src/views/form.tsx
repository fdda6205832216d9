import type { ComponentChildren } from "preact";
import { ApiProblem } from "../api/client";
import { invalidText, serverSentence } from "../texts/problem_text";
import { Notice } from "./shell";

/** The errors of a form, by field. `form` is for errors of the form as a whole. */
export type Faults<Field extends string> = Readonly<Partial<Record<Field | "form", string>>>;

/** Returns the server's errors of these fields, or a sentence for the whole form. */
export function faultsOf<Field extends string>(
  thrown: unknown,
  fields: readonly Field[],
  explain: (thrown: unknown) => string,
): Faults<Field> {
  if (thrown instanceof ApiProblem) {
    const found: Partial<Record<Field, string>> = {};
    for (const field of fields) {
      const message = thrown.errors.find((error) => error.field === field)?.message;
      if (message !== undefined) found[field] = serverSentence(message, invalidText(field));
    }
    if (Object.keys(found).length > 0) return found as Faults<Field>;
  }
  return { form: explain(thrown) } as Faults<Field>;
}

/** Returns the error as an optional property. */
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
          // Focuses the first field with an error once the errors are on the page. Without errors, focuses the button
          // again, which was disabled while waiting.
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
