MODULE dome_link
  ! The link's task in the background: it reads frames of 160 bytes from a socket into the queue.
  PERS num dome_job:=0;
  PERS num dome_taken:=0;
  PERS num dome_done:=0;
  PERS num dome_fault:=0;
  PERS bool dome_hold:=FALSE;
  PERS string dome_kind{3}:=["","",""];
  PERS num dome_value{3,12}:=[[0,0,0,0,0,0,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0,0,0,0],[0,0,0,0,0,0,0,0,0,0,0,0]];
  PERS string dome_word{3}:=["","",""];
  VAR socketdev dome_server;
  VAR socketdev dome_client;
  VAR rawbytes dome_frame;
  VAR clock dome_silence;
  VAR num dome_connection:=0;
  VAR num dome_version:=0;
  VAR num dome_said:=-1;
  VAR bool dome_sound:=TRUE;
  PROC main()
    SocketClose dome_client;
    SocketClose dome_server;
    SocketCreate dome_server;
    SocketBind dome_server,"192.168.125.1",5000;
    SocketListen dome_server;
    WHILE TRUE DO
      dome_serve;
    ENDWHILE
  ENDPROC
  PROC dome_serve()
    SocketAccept dome_server,dome_client\Time:=WAIT_MAX;
    dome_connection:=0;
    dome_alive;
    ! A sender that lives asks again and again.
    WHILE ClkRead(dome_silence)<30 DO
      IF SocketPeek(dome_client)>=160 THEN
        SocketReceive dome_client\RawData:=dome_frame\ReadNoOfBytes:=160;
        dome_alive;
        dome_take;
        dome_reply;
      ELSEIF dome_connection>0 AND dome_said<>dome_done+dome_fault THEN
        dome_reply;
      ELSE
        WaitTime 0.01;
      ENDIF
    ENDWHILE
    SocketClose dome_client;
  ERROR
    SocketClose dome_client;
    RETURN;
  ENDPROC
  PROC dome_alive()
    ClkStop dome_silence;
    ClkReset dome_silence;
    ClkStart dome_silence;
  ENDPROC
  PROC dome_take()
    VAR string kind;
    VAR num number;
    VAR num place;
    dome_sound:=TRUE;
    UnpackRawBytes dome_frame,9,kind\ASCII:=1;
    number:=dome_num(1,8);
    IF kind="J" THEN
      ! A new job begins when nothing of the old one waits. The queue looks empty at every moment of this.
      IF dome_num(13,12)<>dome_job AND (dome_done=dome_taken OR dome_fault>0) THEN
        dome_hold:=FALSE;
        dome_taken:=0;
        dome_done:=0;
        dome_fault:=0;
        dome_version:=0;
        dome_job:=dome_num(13,12);
      ENDIF
      dome_connection:=dome_num(13+12,12);
    ELSEIF dome_connection=0 THEN
      ! Nothing counts before the sender has said who it is.
      RETURN;
    ELSEIF kind="H" THEN
      IF number>=dome_version THEN
        dome_hold:=dome_num(13,12)=1;
        dome_version:=number;
      ENDIF
    ELSEIF number=dome_taken+1 AND dome_taken-dome_done<3 AND dome_fault=0 THEN
      place:=(number-1) MOD 3+1;
      dome_kind{place}:=kind;
      IF kind="E" THEN
        dome_word{place}:=dome_text(13,24);
      ELSE
        FOR k FROM 1 TO 12 DO
          dome_value{place,k}:=dome_num(13+12*(k-1),12);
        ENDFOR
      ENDIF
      IF dome_sound THEN
        dome_taken:=number;
      ELSE
        dome_fault:=number;
      ENDIF
    ENDIF
  ENDPROC
  PROC dome_reply()
    VAR string line;
    dome_said:=dome_done+dome_fault;
    line:="R "+NumToStr(dome_job,0)+" "+NumToStr(dome_connection,0)+" "+NumToStr(dome_taken,0);
    line:=line+" "+NumToStr(dome_done,0)+" "+NumToStr(dome_version,0)+" "+NumToStr(dome_fault,0)+"\0A";
    SocketSend dome_client\Str:=line;
  ENDPROC
  ! The characters of a field, up to its first blank.
  FUNC string dome_text(num at,num length)
    VAR string word;
    UnpackRawBytes dome_frame,at,word\ASCII:=length;
    RETURN StrPart(word,1,StrFind(word,1," ")-1);
  ENDFUNC
  ! The number in a field; 0 in an empty one.
  FUNC num dome_num(num at,num length)
    VAR string word;
    VAR num value:=0;
    word:=dome_text(at,length);
    IF word<>"" THEN
      IF NOT StrToVal(word,value) THEN
        dome_sound:=FALSE;
      ENDIF
    ENDIF
    RETURN value;
  ENDFUNC
ENDMODULE
