import type { ComponentChildren, Ref } from "preact";

export interface TakeFormProps {
  readonly form?: Ref<HTMLFormElement>;
  readonly onSubmit: () => void;
  readonly children: ComponentChildren;
}

/** A form of the dialog for saving, which checks its own fields and sends nothing by itself. */
export function TakeForm({ form, onSubmit, children }: TakeFormProps) {
  return (
    <form
      ref={form ?? null}
      class="take-form"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        onSubmit();
      }}
    >
      {children}
    </form>
  );
}
