"""`atom listen`: what was said, as speech read it and as the coordinator understands it; a stop acts at once."""

import contextlib
from pathlib import Path
from typing import Final

import typer
from rich.console import Console
from rich.markup import escape

from atom_cli.microphone import MicrophoneError, recorded
from atom_cli.services import ServiceError, Services
from contracts.intent import Intent, Understood
from contracts.speech import Transcript
from vocabulary.hot_words import sayable

FILE_BYTES_MAX: Final = 4_000_000
"""More than 15 s of any WAV that speech takes."""
EXIT_NOTHING_MEANT: Final = 1
EXIT_UNSURE: Final = 11


def sound_of(file: Path | None, console: Console) -> bytes:
    """Of the file, or what is said between two presses of Enter. Raises `typer.BadParameter`."""
    if file is not None:
        try:
            with file.open("rb") as opened:
                return opened.read(FILE_BYTES_MAX)
        except OSError as error:
            raise typer.BadParameter(f"{file}: {error.strerror}") from error
    console.input("Enter to talk ")
    try:
        return recorded(lambda: console.input("… Enter to end "))
    except MicrophoneError as error:
        raise typer.BadParameter(str(error)) from error


def heard_by(services: Services, sound: bytes) -> Transcript:
    """With what memory holds as the names to expect; without them where memory is away. Raises `ServiceError`."""
    names: list[str] = []
    with contextlib.suppress(ServiceError):
        names = sayable(one.label for one in services.labels())
    return services.transcribe(sound, names)


def told(console: Console, transcript: Transcript) -> None:
    """Both readings, where they differ."""
    console.print(f"[bold]heard[/]      {escape(transcript.text)}", soft_wrap=True)
    if not transcript.agree:
        console.print(f"[bold]or[/]         {escape(transcript.hot_text)}", soft_wrap=True)


def meant(console: Console, understood: Understood, *, send: bool) -> Intent:
    """What is to be sent, after a person said so; with `send` only what is understood without asking."""
    if understood.intent is not None:
        if understood.intent.able:
            console.print(escape(understood.intent.able), soft_wrap=True)
        if not send:
            typer.confirm(f"Send “{understood.intent.command}”?", abort=True)
        return understood.intent
    console.print(escape(understood.question), soft_wrap=True)
    if send or not understood.choices:
        raise typer.Exit(EXIT_UNSURE)
    for number, choice in enumerate(understood.choices, 1):
        console.print(f"  {number}  {escape(choice.text)}", soft_wrap=True)
    chosen: int = typer.prompt("Which? 0 = none", type=int)
    if not 1 <= chosen <= len(understood.choices):
        raise typer.Exit(EXIT_NOTHING_MEANT)
    return understood.choices[chosen - 1].intent
