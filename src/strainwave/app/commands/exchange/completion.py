"""`strainwave completion`: the scripts of the shells; that of PowerShell, which click does not have, is here."""

import os
from typing import ClassVar

import click
from click.shell_completion import CompletionItem, ShellComplete, get_completion_class, split_arg_string

SHELLS = ("bash", "zsh", "fish", "powershell")
SOURCE = """\
Register-ArgumentCompleter -Native -CommandName %(prog_name)s -ScriptBlock {
    param($word, $ast, $cursor)
    $env:%(complete_var)s = "powershell_complete"
    $text = $ast.ToString()
    $env:COMP_WORDS = $text.Substring(0, [Math]::Min($cursor - $ast.Extent.StartOffset, $text.Length))
    $env:COMP_CWORD = $word
    try { $lines = %(prog_name)s } finally { Remove-Item Env:%(complete_var)s, Env:COMP_WORDS, Env:COMP_CWORD }
    foreach ($line in $lines) {
        $kind, $value, $help = $line -split "`t", 3
        if ($kind -eq "plain") {
            [System.Management.Automation.CompletionResult]::new($value, $value, "ParameterValue", $help)
        } else {
            Get-ChildItem -Path "$word*" -Directory:($kind -eq "dir") | ForEach-Object {
                $path = Resolve-Path -LiteralPath $_.FullName -Relative
                [System.Management.Automation.CompletionResult]::new($path, $_.Name, "ProviderItem", $_.FullName)
            }
        }
    }
}
"""


class PowerShellComplete(ShellComplete):
    """Lines of kind, value and help, parted by tabs."""

    name: ClassVar[str] = "powershell"
    source_template: ClassVar[str] = SOURCE

    def get_completion_args(self) -> tuple[list[str], str]:
        """Words before the one that is typed, and that one."""
        words, typed = split_arg_string(os.environ["COMP_WORDS"]), os.environ["COMP_CWORD"]
        if typed and words and words[-1] == typed:
            words.pop()
        return words[1:], typed

    def format_completion(self, item: CompletionItem) -> str:
        """One line for PowerShell, whose help may not be empty."""
        return f"{item.type}\t{item.value}\t{item.help or item.value}"


@click.command()
@click.argument("shell", type=click.Choice(SHELLS))
def completion(shell: str) -> None:
    """Print a script that completes commands, options, gears and files in SHELL.

    bash: eval "$(strainwave completion bash)" in ~/.bashrc; zsh: the same in ~/.zshrc; fish: strainwave completion fish
    > ~/.config/fish/completions/strainwave.fish; powershell: strainwave completion powershell | Out-String |
    Invoke-Expression in $PROFILE.
    """
    kind = get_completion_class(shell)
    root = click.get_current_context().find_root().command
    assert kind is not None
    click.echo(kind(root, {}, "strainwave", "_STRAINWAVE_COMPLETE").source())
